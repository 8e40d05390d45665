// Pictures of the scene: quick ones while something changes, at as many pixels as the graphics card keeps up
// with, and the full one, in bands, when nothing does.

const kStop = 1e-3;         // as RenderOptions::stop
const kGoodFrame = 1 / 30;  // seconds a quick picture should take
const kBand = 0.03;         // seconds a band of the full picture should take
const kRest = 150;          // milliseconds without a change before the full picture begins

class Painter {
  constructor(gl, scene, camera) {
    this.gl = gl, this.camera = camera;
    this.copy = programOf(gl, document.getElementById("present.frag").textContent);
    this.quick = new Target(gl, gl.RGBA8, gl.LINEAR), this.full = new Target(gl, gl.RGBA8, gl.LINEAR);
    this.share = 0.5;         // of the canvas' pixels an edge that a quick picture has
    this.rowsPerSecond = 400; // of the full picture
    this.dirty = true, this.changed = 0, this.nextRow = 0;
    this.pending = null;      // what the graphics card is busy with
    this.finished = [];       // when the last quick pictures were done, milliseconds
    this.quality = "auto";
    this.drawn = false;       // there was a picture
    this.shown = null;        // which one
    this.show(scene);
  }

  /// Another model, or the first.
  show(scene) {
    this.scene = scene;
    this.march = programOf(this.gl, document.getElementById("march.frag").textContent, scene.defines);
    this.invalidate();
  }

  /// Something is to be seen that was not yet.
  invalidate() { this.dirty = true, this.changed = performance.now(), this.nextRow = 0; }

  /// Rays of rows [first, last) of a target, from its lower edge.
  drawRows(target, look, first, last, stepScale) {
    const gl = this.gl, {scene, camera} = this;
    scene.setTime(look.time);
    const pass = this.march.use();
    scene.bindField(pass);
    pass.float("stepLength", scene.header.step * stepScale), pass.float("stopAt", kStop);
    pass.vec3("eye", camera.position);
    ["axisX", "axisY", "axisZ"].forEach((name, a) => pass.vec3(name, camera.axes[a]));
    pass.vec4("lens", camera.fitted(target.width, target.height)), pass.float("targetHeight", target.height);
    pass.int("shown", Object.keys(kLayers).indexOf(look.layer)), pass.vec3("background", look.background);
    const untouched = hexOf(look.background) === hexOf(scene.header.background);
    if (scene.header.background_harmonics.length) pass.int("learnedBackground", +untouched);
    pass.vec2("depthRange", camera.depthRange()), pass.float("fullFlow", scene.header.full_flow);
    target.begin();
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(0, first, target.width, last - first);
    pass.draw();
    gl.disable(gl.SCISSOR_TEST);
  }

  present(target) {
    this.shown = target;
    const gl = this.gl, canvas = gl.canvas;
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, canvas.width, canvas.height);
    const pass = this.copy.use();
    pass.texture("picture", target.texture, gl.TEXTURE_2D);
    pass.vec2("canvasSize", [canvas.width, canvas.height]);
    pass.draw();
  }

  /// The last picture once more: a canvas of another size is empty.
  again() { if (this.shown) this.present(this.shown); }

  /// True when the last piece of work is done; learns how fast it was.
  idle(now) {
    if (!this.pending) return true;
    const gl = this.gl, {fence, start, learn} = this.pending;
    if (gl.getSyncParameter(fence, gl.SYNC_STATUS) !== gl.SIGNALED) return false;
    gl.deleteSync(fence);
    this.pending = null;
    learn(Math.max(1e-3, (now - start) / 1000), now);
    return true;
  }
  submit(start, learn) {
    const gl = this.gl;
    this.pending = {fence: gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0), start, learn};
    gl.flush();
  }

  /// To be called once per frame of the screen.
  /// @param busy  the picture will change again at once: no full one is begun.
  frame(look, busy) {
    const now = performance.now(), {width, height} = this.gl.canvas;
    if (!this.idle(now)) return;
    if (this.dirty) {
      const full = this.quality === "full", share = full ? 1 : this.share;
      const w = Math.max(1, Math.round(width * share)), h = Math.max(1, Math.round(height * share));
      this.quick.resize(w, h);
      this.drawRows(this.quick, look, 0, h, full ? 1 : 1.5);
      this.present(this.quick);
      this.dirty = false, this.nextRow = full ? height : 0;
      this.submit(now, (seconds, end) => {
        this.finished.push(end), this.drawn = true;
        if (full) return;
        this.rowsPerSecond = h / seconds * share;
        // The time goes with the pixels; a step at a time, because a frame also waits for the screen.
        const better = this.share * Math.sqrt(kGoodFrame / seconds);
        this.share = Math.min(1, Math.max(0.25, 0.6 * this.share + 0.4 * Math.max(better, 0.5 * this.share)));
      });
      return;
    }
    if (busy || this.quality === "fast" || this.nextRow >= height || now - this.changed < kRest) return;
    this.full.resize(width, height);
    const band = Math.max(1, Math.round(this.rowsPerSecond * kBand));
    const last = Math.min(height, this.nextRow + band), rows = last - this.nextRow;
    this.drawRows(this.full, look, this.nextRow, last, 1);
    this.nextRow = last;
    if (last === height) this.present(this.full);
    this.submit(now, seconds => {
      this.rowsPerSecond = 0.5 * this.rowsPerSecond + 0.5 * Math.min(rows / seconds, 4 * this.rowsPerSecond);
    });
  }

  /// Pictures a second of late, 0 when nothing changes.
  rate(now) {
    this.finished = this.finished.filter(t => now - t < 1000);
    return this.finished.length;
  }

  /// A full picture at once, as a 2D canvas.
  picture(look, width, height) {
    const gl = this.gl, target = new Target(gl, gl.RGBA8, gl.LINEAR);
    target.resize(width, height);
    this.drawRows(target, look, 0, height, 1);
    const pixels = new Uint8ClampedArray(4 * width * height), flipped = new ImageData(width, height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    for (let y = 0; y < height; ++y) {
      const row = height - 1 - y;
      flipped.data.set(pixels.subarray(4 * width * row, 4 * width * (row + 1)), 4 * width * y);
    }
    target.free();
    const canvas = document.createElement("canvas");
    canvas.width = width, canvas.height = height;
    canvas.getContext("2d").putImageData(flipped, 0, 0);
    return canvas;
  }
}
