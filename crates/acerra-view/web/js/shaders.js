// The programs that WebGL2 draws by: level, phase or sign of a field through a table of colours, and copies.

/** @typedef {{program: WebGLProgram, shaders: WebGLShader[], places: Map<string, WebGLUniformLocation | null>, isChecked: boolean}} Program */

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

/** Places along the table of colours, by mode. */
const SHARES = [
  "  return (level(z * u_scale.x) GAIN - u_window.x) / (u_window.y - u_window.x);",
  "  return atan(z.y, z.x) / 6.28318531 + 0.5;",
  "  return 0.5 + 0.5 * z.x GAIN / u_window.y;",
  "  return 0.5 + 0.5 * (level(z * u_scale.x) - level(texture(u_other, v_texture).rg * u_scale.y)) / u_window.y;",
  "  return length(z);",
];

// One program for each way to look at a field: where a processor renders, every branch costs.
/** @param {number} mode 0 level, 1 phase, 2 signed, 3 difference of levels, 4 modulus @param {boolean} gain */
export const fragment = (mode, gain) => `#version 300 es
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
}`.replace("GAIN", gain ? (mode === 2 ? "* exp2(0.166096405 * gain_db())" : "+ gain_db()") : "");

/** A picture copied, its colours multiplied by their opacity. */
export const COPY = `#version 300 es
precision highp float;
uniform sampler2D u_field;
uniform float u_opacity;
in vec2 v_texture;
out vec4 colour;
void main() {
  colour = texture(u_field, v_texture) * u_opacity;
}`;

/** Sets a program off; whether it has come about is asked when it is used. @param {WebGL2RenderingContext} gl @param {string} fragmentText */
export function link(gl, fragmentText) {
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
export function check(gl, { program, shaders }) {
  if (gl.getProgramParameter(program, gl.LINK_STATUS)) return;
  const told = [...shaders.map((shader) => gl.getShaderInfoLog(shader)), gl.getProgramInfoLog(program)];
  throw new Error(told.find((text) => text) ?? "a program for drawing cannot be made");
}
