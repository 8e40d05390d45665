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
    this.untouched = !location.hash;  // nobody has said which time is to be shown
    bindPointers(this.canvas, this.camera, () => this.moved());
    bindPanel(this);
    this.canvas.addEventListener("webglcontextlost", e => {
      e.preventDefault();
      complain("The graphics card was taken away from this page. Load it again.");
    });
    window.addEventListener("hashchange", () => {
      if (location.hash === this.written) return;
      this.untouched = false;
      this.readAddress();
    });
    new ResizeObserver(() => this.resize()).observe(this.canvas);
    this.resize();
    this.readAddress();
    this.last = performance.now();
    requestAnimationFrame(now => this.tick(now));
  }

  /// Another model of the same scene. Camera, time and layer stay.
  replace(header, bytes) {
    if (this.gl.isContextLost()) return;  // which has been said
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
    if (this.state.read(location.hash) || !this.placed) this.applyView();
    this.placed = true;
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
    if ("time" in changes || "playing" in changes) {
      this.untouched = false;
      this.state.loop();
    }
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
    this.set({picked: null});
  }
  moved() { this.set({view: -1}); }
  nudge(yaw, pitch, zoom) {
    this.camera.turn(yaw, pitch), this.camera.zoom(zoom);
    this.moved();
  }
  save() {
    const picture = this.painter.picture(this.state.look, this.canvas.width, this.canvas.height);
    this.hand(picture.toDataURL("image/png"), `${this.state.time.toFixed(3)}.png`);
  }
  /// Gives a file to whoever looks. @param end  of its name
  hand(address, end) {
    const link = document.createElement("a");
    link.download = `${this.header.name}_${this.state.layer}_${end}`;
    link.href = address;
    link.click();
  }
  /// A film of what the canvas shows while time goes by once, or until it is stopped.
  record() {
    if (this.recorder) return this.set({playing: false});
    const stream = this.canvas.captureStream(), {type, end} = filmType(), parts = [];
    this.recorder = new MediaRecorder(stream, {mimeType: type, videoBitsPerSecond: kFilmBits});
    this.recorder.addEventListener("dataavailable", e => parts.push(e.data));
    this.recorder.addEventListener("stop", () => {
      stream.getTracks().forEach(track => track.stop());
      this.recorder = null;
      const address = URL.createObjectURL(new Blob(parts, {type}));
      this.hand(address, "film" + end);
      setTimeout(() => URL.revokeObjectURL(address), 60000);
      this.set({});
    });
    this.recorder.start();
    this.playOnce(0, 1);
  }
  fullScreen() {
    if (document.fullscreenElement) document.exitFullscreen();
    else document.documentElement.requestFullscreen?.().catch(() => {});
  }
  /// Plays all of time once, from a moment on, and rests there or at another.
  playOnce(from, rest = from) {
    this.state.playOnce(from, rest);
    this.set({});
  }
  /// What a page does once it shows something, if nobody has done anything yet.
  open() {
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    if (this.untouched && this.header.motion && !still) this.playOnce(this.state.time);
  }
  /// "test view r_003": pictures of several splits may have one name.
  nameOf(view) { return `${this.header.split} view ${view.name}`; }

  resize() {
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    const width = Math.max(1, Math.round(this.canvas.clientWidth * ratio));
    const height = Math.max(1, Math.round(this.canvas.clientHeight * ratio));
    if (this.canvas.width === width && this.canvas.height === height) return;
    this.canvas.width = width, this.canvas.height = height;
    this.painter.again(), this.painter.invalidate();
  }

  tick(now) {
    if (this.gl.isContextLost()) return;
    if (this.state.playing) {
      this.state.advance(Math.min(0.25, (now - this.last) / 1000));
      this.set({});
    }
    this.last = now;
    this.painter.frame(this.state.look, this.state.playing);
    if (this.recorder?.state === "recording" && !this.state.playing) this.recorder.stop();
    if (this.painter.drawn && document.body.classList.contains("loading")) {
      document.body.classList.remove("loading");
      this.opened?.();
    }
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

const kFilmBits = 12e6;  // a second

/// The kind of film that this browser records, and how its file's name ends; null: none.
function filmType() {
  const kinds = [["video/webm;codecs=vp9", ".webm"], ["video/webm", ".webm"], ["video/mp4", ".mp4"]];
  if (!window.MediaRecorder || !HTMLCanvasElement.prototype.captureStream) return null;
  const found = kinds.find(([type]) => MediaRecorder.isTypeSupported(type));
  return found ? {type: found[0], end: found[1]} : null;
}

function complain(text) {
  $("problem").textContent = text;
  $("problem").hidden = false;
  document.body.classList.remove("loading");
  document.body.classList.add("still");
}
