// Drawing fields of complex values by WebGL2: level, phase or sign through a table of colours.

const VERTEX = `#version 300 es
uniform vec4 u_clip;   // left, bottom, right, top in clip coordinates
uniform vec4 u_part;   // the part of the texture: u0, v0, u1, v1
uniform vec4 u_place;  // the same within the gain's samples
out vec2 v_texture;
out vec2 v_gain;
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  v_texture = mix(u_part.xy, u_part.zw, corner);
  v_gain = mix(u_place.xy, u_place.zw, corner);
  gl_Position = vec4(mix(u_clip.xy, u_clip.zw, corner), 0.0, 1.0);
}`;

// One program for each way to look at a field: where a processor renders, every branch costs.
/** @param {number} mode 0 level, 1 phase, 2 signed, 3 difference of levels, 4 modulus @param {boolean} gain */
const fragment = (mode, gain) => `#version 300 es
precision highp float;
uniform highp sampler2D u_field;
uniform highp sampler2D u_other;
uniform highp sampler2D u_nodes;
uniform sampler2D u_colours;
uniform vec2 u_window;     // lowest and highest level shown, dB
uniform vec2 u_scale;      // amplitudes at 0 dB, inverse: of the field and of the other
uniform float u_opacity;
in vec2 v_texture;
in vec2 v_gain;
out vec4 colour;
const float DB = 3.01029996;
float gain_db() {
  vec2 last = vec2(textureSize(u_nodes, 0) - 1);
  vec2 place = clamp(v_gain, 0.0, 1.0) * last;
  ivec2 cell = ivec2(min(floor(place), last - 1.0));
  vec2 part = place - vec2(cell);
  float a = texelFetch(u_nodes, cell, 0).r, b = texelFetch(u_nodes, cell + ivec2(1, 0), 0).r;
  float c = texelFetch(u_nodes, cell + ivec2(0, 1), 0).r, d = texelFetch(u_nodes, cell + ivec2(1, 1), 0).r;
  return mix(mix(a, b, part.x), mix(c, d, part.x), part.y);
}
float level(vec2 z) {
  return DB * log2(max(dot(z, z), 1e-37));
}
float share(vec2 z) {
${SHARES[mode]}
}
void main() {
  vec2 z = texture(u_field, v_texture).rg;
  float at = clamp(share(z), 0.0, 1.0);
  vec3 rgb = texelFetch(u_colours, ivec2(int(at * 255.0 + 0.5), 0), 0).rgb;
  // Not a number: grey.
  colour = vec4(z.x + z.y == z.x + z.y ? rgb : vec3(0.60, 0.62, 0.65), 1.0) * u_opacity;
}`.replace("GAIN", gain ? "+ gain_db()" : "");

/** The drawing over the field, its colours multiplied by their opacity. */
const OVERLAY = `#version 300 es
precision mediump float;
uniform sampler2D u_field;
in vec2 v_texture;
out vec4 colour;
void main() {
  colour = texture(u_field, v_texture);
}`;

/** Names of renderers that are a processor. */
const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;

/** Places along the table of colours, by mode. */
const SHARES = [
  "  return (level(z * u_scale.x) GAIN - u_window.x) / (u_window.y - u_window.x);",
  "  return atan(z.y, z.x) / 6.28318531 + 0.5;",
  "  return 0.5 + 0.5 * z.x / u_window.y;",
  "  return 0.5 + 0.5 * (level(z * u_scale.x) - level(texture(u_other, v_texture).rg * u_scale.y)) / u_window.y;",
  "  return length(z);",
];

/** @typedef {{mode: number, window: [number, number], zero_db: number, other_zero_db: number, gain: WebGLTexture | null, colours: WebGLTexture, opacity: number}} Look */
/** @typedef {[number, number, number, number]} Rectangle */

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
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  /** Draws only from a share of the width to another. @param {number} from @param {number} to */
  within(from, to) {
    const { gl, canvas } = this;
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(Math.round(from * canvas.width), 0, Math.round((to - from) * canvas.width), canvas.height);
  }

  /** How fields look until the next call. @param {Look} look */
  look(look) {
    const { gl } = this;
    this.take(this.use(look.mode, look.gain !== null && look.mode === 0));
    gl.uniform2f(this.place("u_window"), look.window[0], look.window[1]);
    gl.uniform2f(this.place("u_scale"), 10 ** (-look.zero_db / 20), 10 ** (-look.other_zero_db / 20));
    gl.uniform1f(this.place("u_opacity"), look.opacity);
    if (look.opacity < 1) gl.enable(gl.BLEND);
    else gl.disable(gl.BLEND);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, look.colours);
    gl.activeTexture(gl.TEXTURE2);
    gl.bindTexture(gl.TEXTURE_2D, look.gain ?? this.blank);
  }

  /**
   * Draws a part of a field.
   * @param {WebGLTexture} field @param {WebGLTexture | null} other
   * @param {{clip: Rectangle, part: Rectangle, place: Rectangle}} at
   */
  draw(field, other, at) {
    const { gl } = this;
    gl.activeTexture(gl.TEXTURE3);
    gl.bindTexture(gl.TEXTURE_2D, other ?? this.blank);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, field);
    gl.uniform4f(this.place("u_clip"), ...at.clip);
    gl.uniform4f(this.place("u_part"), ...at.part);
    gl.uniform4f(this.place("u_place"), ...at.place);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
  }

  /** Lays a drawing of the canvas's size over the field. @param {HTMLCanvasElement} drawing */
  over(drawing) {
    const { gl } = this;
    const { width, height } = drawing;
    this.take(this.programOf("overlay", () => OVERLAY));
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
    gl.enable(gl.BLEND);
    gl.uniform4f(this.place("u_clip"), -1, 1, 1, -1);
    gl.uniform4f(this.place("u_part"), 0, 0, 1, 1);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
  }
}

/** @typedef {{program: WebGLProgram, shaders: WebGLShader[], places: Map<string, WebGLUniformLocation | null>, isChecked: boolean}} Program */

/** Sets a program off; whether it has come about is asked when it is used. @param {WebGL2RenderingContext} gl @param {string} fragmentText */
function link(gl, fragmentText) {
  const program = gl.createProgram();
  if (!program) throw new Error("WebGL2 is out of order");
  const shaders = /** @type {[number, string][]} */ ([[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, fragmentText]]).map(([kind, text]) => {
    const shader = gl.createShader(kind);
    if (!shader) throw new Error("WebGL2 is out of order");
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
    return shader;
  });
  gl.linkProgram(program);
  return { program, shaders };
}

/** @param {WebGL2RenderingContext} gl @param {Program} made */
function check(gl, { program, shaders }) {
  if (gl.getProgramParameter(program, gl.LINK_STATUS)) return;
  const told = [...shaders.map((shader) => gl.getShaderInfoLog(shader)), gl.getProgramInfoLog(program)];
  throw new Error(told.find((text) => text) ?? "a program for drawing cannot be made");
}
