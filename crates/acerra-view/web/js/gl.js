// Drawing fields of complex values by WebGL2.

import { COPY, check, fragment, link } from "./shaders.js";

/** Names of renderers that are a processor. */
const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;

/** @typedef {{mode: number, window: [number, number], zero_db: number, other_zero_db: number, gain: WebGLTexture | null, colours: WebGLTexture, opacity: number}} Look */
/** @typedef {import("./shaders.js").Program} Program */
/** @typedef {[number, number, number, number]} Rectangle */
/** @typedef {{clip: Rectangle, part: Rectangle, place: Rectangle}} At where on the canvas, which part of the texture, and where within the gain */

export class Painter {
  /** @param {HTMLCanvasElement} canvas @param {boolean} clear whether what lies under the canvas is seen where nothing is drawn */
  constructor(canvas, clear) {
    const options = { alpha: clear, antialias: false, depth: false, preserveDrawingBuffer: false };
    const gl = /** @type {WebGL2RenderingContext | null} */ (canvas.getContext("webgl2", options));
    if (!gl) throw new Error("this browser offers no WebGL2, which the image needs");
    this.canvas = canvas;
    this.gl = gl;
    /** @type {Map<string, Program>} */
    this.programs = new Map();
    /** @type {Program | null} */
    this.program = null;
    /** How fields look at present. @type {Look | null} */
    this.shown = null;
    /** The same as a text: looks of one text give one picture. */
    this.key = "";
    /** Whether program and uniforms are those of the present look. */
    this.isBrought = false;
    this.isClipped = false;
    /** Tiles coloured since the picture was begun. */
    this.colouredNow = 0;
    /** Numbers of the textures that looks name. @type {WeakMap<WebGLTexture, number>} */
    this.numbers = new WeakMap();
    this.counted = 0;
    /** @type {WebGLFramebuffer | null} */
    this.frame = null;
    const told = gl.getExtension("WEBGL_debug_renderer_info");
    /** Whether a processor draws: layers laid over one another are dear then. */
    this.isSoftware = SOFTWARE.test(String(gl.getParameter(told ? told.UNMASKED_RENDERER_WEBGL : gl.RENDERER)));
    /** @type {{texture: WebGLTexture, width: number, height: number} | null} */
    this.sheet = null;
    gl.bindVertexArray(gl.createVertexArray());
    this.blank = this.field(1, 1, new Float32Array(2));
  }

  /** The program of a mode, made when it is first used. @param {number} mode @param {boolean} gain @returns {Program} */
  use(mode, gain) {
    return this.programOf(`${mode}/${gain}`, () => fragment(mode, gain));
  }

  /** @param {string} key @param {() => string} text @returns {Program} */
  programOf(key, text) {
    const { gl } = this;
    let made = this.programs.get(key);
    if (!made) {
      made = { ...link(gl, text()), places: new Map(), isChecked: false };
      this.programs.set(key, made);
    }
    return made;
  }

  /** Has a program made while other things are waited for. @param {number} mode @param {boolean} gain */
  foresee(mode, gain) {
    this.use(mode, gain);
  }

  /** Draws by a program from now on. @param {Program} made */
  take(made) {
    const { gl } = this;
    this.program = made;
    if (made.isChecked) {
      gl.useProgram(made.program);
      return;
    }
    made.isChecked = true;
    check(gl, made);
    gl.useProgram(made.program);
    for (const [unit, name] of ["u_field", "u_colours", "u_nodes", "u_other"].entries()) {
      gl.uniform1i(gl.getUniformLocation(made.program, name), unit);
    }
  }

  /** @param {string} name */
  place(name) {
    if (!this.program) return null;
    const { places, program } = this.program;
    if (!places.has(name)) places.set(name, this.gl.getUniformLocation(program, name));
    return places.get(name) ?? null;
  }

  /** A texture of pairs. @param {number} columns @param {number} rows @param {Float32Array} values */
  field(columns, rows, values) {
    const { gl } = this;
    return this.texture(gl.RG32F, gl.RG, gl.FLOAT, [columns, rows], values, gl.NEAREST);
  }

  /** A texture of pairs in half precision. @param {number} columns @param {number} rows @param {Uint16Array} bits */
  halfField(columns, rows, bits) {
    const { gl } = this;
    return this.texture(gl.RG16F, gl.RG, gl.HALF_FLOAT, [columns, rows], bits, gl.NEAREST);
  }

  /** A texture of a gain's samples. @param {number} nodes @param {Float32Array} values */
  nodes(nodes, values) {
    const { gl } = this;
    return this.texture(gl.R32F, gl.RED, gl.FLOAT, [nodes, nodes], values, gl.NEAREST);
  }

  /** A texture of colours. @param {Uint8Array} values red, green, blue, opacity */
  colours(values) {
    const { gl } = this;
    return this.texture(gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, [values.length / 4, 1], values, gl.NEAREST);
  }

  /**
   * @param {number} inside @param {number} format @param {number} type @param {number[]} size
   * @param {ArrayBufferView | null} values @param {number} filter
   */
  texture(inside, format, type, size, values, filter) {
    const { gl } = this;
    const texture = gl.createTexture();
    if (!texture) throw new Error("the graphics memory is full");
    gl.activeTexture(gl.TEXTURE7);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texStorage2D(gl.TEXTURE_2D, 1, inside, size[0], size[1]);
    if (values) gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, size[0], size[1], format, type, values);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, filter);
    for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
    return texture;
  }

  /** @param {WebGLTexture} texture */
  forget(texture) {
    this.gl.deleteTexture(texture);
  }

  /** Begins a picture of so many CSS pixels. @param {number} width @param {number} height @param {number} ratio */
  begin(width, height, ratio) {
    const { gl, canvas } = this;
    const [w, h] = [Math.max(1, Math.round(width * ratio)), Math.max(1, Math.round(height * ratio))];
    if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
    gl.viewport(0, 0, w, h);
    gl.disable(gl.SCISSOR_TEST);
    this.isClipped = false;
    this.colouredNow = 0;
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  /** Draws only from a share of the width to another. @param {number} from @param {number} to */
  within(from, to) {
    const { gl, canvas } = this;
    gl.enable(gl.SCISSOR_TEST);
    this.isClipped = true;
    gl.scissor(Math.round(from * canvas.width), 0, Math.round((to - from) * canvas.width), canvas.height);
  }

  /** How fields look until the next call. @param {Look} look */
  look(look) {
    const number = (/** @type {WebGLTexture | null} */ texture) => {
      if (!texture) return 0;
      if (!this.numbers.has(texture)) this.numbers.set(texture, (this.counted += 1));
      return this.numbers.get(texture);
    };
    this.shown = look;
    this.key = [look.mode, ...look.window, look.zero_db, look.other_zero_db, number(look.gain), number(look.colours)].join();
    this.isBrought = false;
  }

  /** Sets the present look's program and uniforms. @param {number} opacity */
  bring(opacity) {
    const { gl, shown } = this;
    if (!shown) return;
    this.take(this.use(shown.mode, shown.gain !== null && (shown.mode === 0 || shown.mode === 2)));
    gl.uniform2f(this.place("u_window"), shown.window[0], shown.window[1]);
    gl.uniform2f(this.place("u_scale"), 10 ** (-shown.zero_db / 20), 10 ** (-shown.other_zero_db / 20));
    this.blend(opacity);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, shown.colours);
    gl.activeTexture(gl.TEXTURE2);
    gl.bindTexture(gl.TEXTURE_2D, shown.gain ?? this.blank);
  }

  /** @param {number} opacity */
  blend(opacity) {
    const { gl } = this;
    gl.uniform1f(this.place("u_opacity"), opacity);
    if (opacity < 1) gl.enable(gl.BLEND);
    else gl.disable(gl.BLEND);
  }

  /**
   * Draws a part of a field.
   * @param {WebGLTexture} field @param {WebGLTexture | null} other @param {At} at
   */
  draw(field, other, at) {
    const { gl } = this;
    if (!this.isBrought) this.bring(this.shown?.opacity ?? 1);
    this.isBrought = true;
    gl.activeTexture(gl.TEXTURE3);
    gl.bindTexture(gl.TEXTURE_2D, other ?? this.blank);
    this.rectangle(field, at);
  }

  /** The colours of a whole field by the present look, as a texture. @param {WebGLTexture} field @param {[number, number]} size @param {Rectangle} place */
  coloured(field, size, place) {
    const { gl, canvas } = this;
    const colours = this.texture(gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, size, null, gl.NEAREST);
    this.frame ??= gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.frame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, colours, 0);
    gl.viewport(0, 0, size[0], size[1]);
    gl.disable(gl.SCISSOR_TEST);
    this.bring(1);
    this.rectangle(field, { clip: [-1, -1, 1, 1], part: [0, 0, 1, 1], place });
    this.isBrought = false;
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, canvas.width, canvas.height);
    if (this.isClipped) gl.enable(gl.SCISSOR_TEST);
    return colours;
  }

  /** Draws a part of a picture as it is. @param {WebGLTexture} picture @param {At} at @param {number} opacity */
  copy(picture, at, opacity) {
    this.take(this.programOf("copy", () => COPY));
    this.isBrought = false;
    this.blend(opacity);
    this.rectangle(picture, at);
  }

  /** @param {WebGLTexture} texture @param {At} at */
  rectangle(texture, at) {
    const { gl } = this;
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.uniform4f(this.place("u_clip"), ...at.clip);
    gl.uniform4f(this.place("u_part"), ...at.part);
    gl.uniform4f(this.place("u_place"), ...at.place);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
  }

  /** Lays a drawing of the canvas's size over the field. @param {HTMLCanvasElement} drawing */
  over(drawing) {
    const { gl } = this;
    const { width, height } = drawing;
    gl.activeTexture(gl.TEXTURE0);
    if (this.sheet?.width !== width || this.sheet.height !== height) {
      if (this.sheet) gl.deleteTexture(this.sheet.texture);
      this.sheet = { texture: this.texture(gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, [width, height], null, gl.NEAREST), width, height };
      gl.activeTexture(gl.TEXTURE0);
    }
    gl.bindTexture(gl.TEXTURE_2D, this.sheet.texture);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, true);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, drawing);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    gl.disable(gl.SCISSOR_TEST);
    this.isClipped = false;
    this.take(this.programOf("copy", () => COPY));
    this.isBrought = false;
    gl.uniform1f(this.place("u_opacity"), 1);
    gl.enable(gl.BLEND);
    this.rectangle(this.sheet.texture, { clip: [-1, 1, 1, -1], part: [0, 0, 1, 1], place: [0, 0, 1, 1] });
  }
}
