// The viewer as a whole: makes it, and runs the loop.

class App {
  constructor(header, bytes) {
    this.header = header;
    this.canvas = $("canvas");
    this.gl = openGl(this.canvas);
    this.scene = new Scene(this.gl, header, bytes);
    this.camera = new OrbitCamera(header);
    this.painter = new Painter(this.gl, this.scene, this.camera);
    this.state = new State(header);
    this.compared = 0;
    bindPointers(this.canvas, this.camera, () => this.moved());
    bindPanel(this);
    this.canvas.addEventListener("webglcontextlost", e => {
      e.preventDefault();
      complain("The graphics card was taken away from this page. Load it again.");
    });
    window.addEventListener("hashchange", () => { if (location.hash !== this.written) this.readAddress(); });
    new ResizeObserver(() => this.resize()).observe(this.canvas);
    this.resize();
    this.readAddress();
    this.last = performance.now();
    requestAnimationFrame(now => this.tick(now));
  }

  /// Another model of the same scene. Camera, time and layer stay.
  replace(header, bytes) {
    const old = this.scene;
    this.scene = new Scene(this.gl, header, bytes);
    old.free();
    this.header = header;
    this.camera.fit(header);
    this.painter.show(this.scene);
    this.state.show(header);
    showLayers(this);
    $("note").textContent = header.note;
    this.set({});
  }

  readAddress() {
    this.state.read(location.hash);
    this.applyView();
    this.set({});
  }
  applyView() {
    if (this.state.view < 0) return this.camera.home();
    this.camera.take(this.header.views[this.state.view].camera);
    this.compared = this.state.view;
  }

  /// Changes the state and whatever follows from it.
  set(changes) {
    Object.assign(this.state, changes);
    showState(this);
    this.painter.invalidate();
    clearTimeout(this.writing);
    this.writing = setTimeout(() => this.writeAddress(), 300);
  }
  writeAddress() {
    if (this.state.playing) return;
    this.written = this.state.write();
    try {
      history.replaceState(null, "", this.written);
    } catch (e) { /* a sandboxed frame has no address of its own */ }
  }

  goTo(view) {
    this.state.view = view;
    this.applyView();
    this.set({time: this.header.views[view].time, playing: false});
  }
  /// Beside the picture of the view that was looked at last.
  compare() {
    if (!this.header.views.length) return;
    this.set({compare: !this.state.compare});
    if (this.state.compare && this.state.view !== this.compared) this.goTo(this.compared);
  }
  reset() {
    this.state.view = this.state.first;
    this.applyView();
    this.set({background: this.header.background});
  }
  moved() { this.set({view: -1}); }
  nudge(yaw, pitch, zoom) {
    this.camera.turn(yaw, pitch), this.camera.zoom(zoom);
    this.moved();
  }
  save() {
    const link = document.createElement("a");
    link.download = `${this.header.name}_${this.state.layer}_${this.state.time.toFixed(3)}.png`;
    const picture = this.painter.picture(this.state.look, this.canvas.width, this.canvas.height);
    link.href = picture.toDataURL("image/png");
    link.click();
  }

  resize() {
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    const width = Math.max(1, Math.round(this.canvas.clientWidth * ratio));
    const height = Math.max(1, Math.round(this.canvas.clientHeight * ratio));
    if (this.canvas.width === width && this.canvas.height === height) return;
    this.canvas.width = width, this.canvas.height = height;
    this.painter.invalidate();
  }

  tick(now) {
    if (this.state.playing) {
      this.state.advance(Math.min(0.25, (now - this.last) / 1000));
      showState(this);
      this.painter.invalidate();
    }
    this.last = now;
    this.painter.frame(this.state.look, this.state.playing);
    const rate = this.painter.rate(now);
    $("rate").textContent = rate > 1 ? `${rate} frames/s` : "";
    requestAnimationFrame(next => this.tick(next));
  }

  /// A picture of `width` x `height` pixels as the address `hash` describes it: the address of a PNG.
  picture(hash, width, height) {
    this.state.read(hash);
    this.applyView();
    this.set({});
    return this.painter.picture(this.state.look, width, height).toDataURL("image/png");
  }
}

function complain(text) {
  $("problem").textContent = text;
  $("problem").hidden = false;
  document.body.classList.remove("loading");
}
