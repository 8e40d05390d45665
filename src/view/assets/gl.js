// Thin helpers over WebGL2. Whatever cannot be done throws an Error whose message a person can read.

/// Functions that several shaders share: where a place at this time was, how bright it is, and what is added
/// to its raw density (math/activation.hpp, math/light.hpp, math/presence.hpp).
const kWarpSource = `
float sigmoid(float x) { return 1.0 / (1.0 + exp(-x)); }
#if CHANGES
uniform sampler3D slice;
uniform sampler3D sliceScalars;     // LIGHT, PRESENCE: their components, if there are any
uniform vec3 motionOrigin;
uniform float motionInverseSpacing, rigidityOffset;
vec3 motionAt(vec3 x, inout float gain, inout float presence, inout float r) {
  vec3 at = ((x - motionOrigin) * motionInverseSpacing + 0.5) / vec3(textureSize(slice, 0));
  vec4 m = texture(slice, at);
#ifdef LIGHT
  gain = 2.0 * sigmoid(texture(sliceScalars, at).LIGHT);
#endif
#ifdef PRESENCE
  presence = texture(sliceScalars, at).PRESENCE;
#endif
#if RIGIDITY
  r = sigmoid(m.w + rigidityOffset);
#endif
  return r * m.xyz;
}
#else
vec3 motionAt(vec3 x, inout float gain, inout float presence, inout float r) { r = 0.0; return vec3(0.0); }
#endif
vec3 displacement(vec3 x) {
  float gain = 1.0, presence = 0.0, r = 1.0;
  return motionAt(x, gain, presence, r);
}
`;

/// Grids of cells that are only ever fetched lie in one 2D texture, eight layers to a row, so that one pass
/// draws them all: a pass per layer is what a phone takes longest for.
const kTilesSource = `
ivec2 tileOf(ivec3 cell, ivec3 size) {
  return ivec2((cell.z & 7) * size.x + cell.x, (cell.z >> 3) * size.y + cell.y);
}
ivec3 cellOf(ivec2 at, ivec3 size) {
  return ivec3(at.x % size.x, at.y % size.y, at.y / size.y * 8 + at.x / size.x);
}
`;
const tiledShape = size => [8 * size[0], Math.ceil(size[2] / 8) * size[1]];

function openGl(canvas) {
  const gl = canvas.getContext("webgl2", {
    alpha: false, antialias: false, depth: false, preserveDrawingBuffer: true,
    powerPreference: "high-performance"
  });
  if (!gl)
    throw new Error("This page needs WebGL 2, which this browser does not offer here. A recent Firefox, " +
      "Chrome, Edge or Safari has it; hardware acceleration may be switched off in the settings.");
  if (!gl.getExtension("EXT_color_buffer_float") && !gl.getExtension("EXT_color_buffer_half_float"))
    throw new Error("This graphics card cannot draw into half-float textures " +
      "(EXT_color_buffer_half_float), which the motion needs.");
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.bindVertexArray(gl.createVertexArray());
  return gl;
}

/// A program over the full target.
/// @param source  of the fragment shader, without version; defines come before it.
class Program {
  constructor(gl, source, defines = "") {
    this.gl = gl;
    this.program = gl.createProgram();
    const head =
      "#version 300 es\nprecision highp float;\nprecision highp int;\nprecision highp sampler3D;\n";
    this.attach(gl.VERTEX_SHADER, head + document.getElementById("pass.vert").textContent);
    this.attach(gl.FRAGMENT_SHADER, head + defines + source);
    gl.linkProgram(this.program);
    if (!gl.getProgramParameter(this.program, gl.LINK_STATUS))
      throw new Error("A shader was refused: " + gl.getProgramInfoLog(this.program));
    this.places = new Map();
  }
  attach(type, text) {
    const gl = this.gl, shader = gl.createShader(type);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS))
      throw new Error("A shader was refused: " + gl.getShaderInfoLog(shader));
    gl.attachShader(this.program, shader);
  }
  place(name) {
    if (!this.places.has(name)) this.places.set(name, this.gl.getUniformLocation(this.program, name));
    return this.places.get(name);
  }
  use() {
    this.gl.useProgram(this.program);
    this.units = 0;
    return this;
  }
  texture(name, texture, target = this.gl.TEXTURE_3D) {
    const gl = this.gl;
    gl.activeTexture(gl.TEXTURE0 + this.units);
    gl.bindTexture(target, texture);
    gl.uniform1i(this.place(name), this.units++);
  }
  int(name, v) { this.gl.uniform1i(this.place(name), v); }
  float(name, v) { this.gl.uniform1f(this.place(name), v); }
  floats(name, v) { this.gl.uniform1fv(this.place(name), v); }
  vec2(name, v) { this.gl.uniform2fv(this.place(name), v); }
  vec3(name, v) { this.gl.uniform3fv(this.place(name), v); }
  vec4(name, v) { this.gl.uniform4fv(this.place(name), v); }
  ivec3(name, v) { this.gl.uniform3iv(this.place(name), v); }
  draw() { this.gl.drawArrays(this.gl.TRIANGLES, 0, 3); }
}

/// The program of these texts: models that follow one another on a page mostly have the same.
function programOf(gl, source, defines = "") {
  gl.programs ??= new Map();
  const text = defines + source;
  if (!gl.programs.has(text)) gl.programs.set(text, new Program(gl, source, defines));
  return gl.programs.get(text);
}

/// An empty 3D texture, clamped at its edges.
function texture3d(gl, format, size, filter) {
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_3D, texture);
  gl.texStorage3D(gl.TEXTURE_3D, 1, format, size[0], size[1], size[2]);
  for (const axis of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T, gl.TEXTURE_WRAP_R])
    gl.texParameteri(gl.TEXTURE_3D, axis, gl.CLAMP_TO_EDGE);
  gl.texParameteri(gl.TEXTURE_3D, gl.TEXTURE_MIN_FILTER, filter);
  gl.texParameteri(gl.TEXTURE_3D, gl.TEXTURE_MAG_FILTER, filter);
  return texture;
}

function texture2d(gl, format, width, height, filter) {
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
  for (const axis of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T])
    gl.texParameteri(gl.TEXTURE_2D, axis, gl.CLAMP_TO_EDGE);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, filter);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, filter);
  return texture;
}

/// Draws a program into every layer of 3D textures of one size.
/// @param framebuffer  always used for the same number of them.
function drawLayers(gl, framebuffer, textures, size, program) {
  gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
  gl.drawBuffers(textures.map((_, i) => gl.COLOR_ATTACHMENT0 + i));
  gl.viewport(0, 0, size[0], size[1]);
  for (let z = 0; z < size[2]; ++z) {
    textures.forEach((t, i) => gl.framebufferTextureLayer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, t, 0, z));
    program.int("layer", z);
    program.draw();
  }
}

/// A 2D texture that is drawn into.
class Target {
  constructor(gl, format, filter) {
    this.gl = gl;
    this.format = format;
    this.filter = filter;
    this.framebuffer = gl.createFramebuffer();
    this.texture = null;
  }
  resize(width, height) {
    if (this.texture && this.width === width && this.height === height) return;
    const gl = this.gl;
    if (this.texture) gl.deleteTexture(this.texture);
    this.width = width, this.height = height;
    this.texture = texture2d(gl, this.format, width, height, this.filter);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.texture, 0);
  }
  free() { this.gl.deleteTexture(this.texture), this.gl.deleteFramebuffer(this.framebuffer); }
  /// What is drawn from here on goes into it.
  begin() {
    this.gl.bindFramebuffer(this.gl.FRAMEBUFFER, this.framebuffer);
    this.gl.viewport(0, 0, this.width, this.height);
  }
}
