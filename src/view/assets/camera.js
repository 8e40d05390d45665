// A camera that goes round a point: position and axes as in include/splinevox/core/camera.hpp (x right, y up,
// looking along -z).

const add = (a, b, s = 1) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = a => a.map(v => v / Math.sqrt(dot(a, a)));
/// v turned about a unit axis (Rodrigues).
const turned = (v, axis, angle) => {
  const c = Math.cos(angle), s = Math.sin(angle);
  return add(add(v.map(k => k * c), cross(axis, v), s), axis, dot(axis, v) * (1 - c));
};

// Around the places where pictures were taken: how far one may go, and where all is unknown.
const kFree = 5 * Math.PI / 180;   // from the nearest camera, or as far as those are from each other
const kSoft = 20 * Math.PI / 180;  // and from there on
const kNearer = 0.8, kSoftRatio = 1.6;  // the same for distances

class OrbitCamera {
  constructor(header) {
    this.taken = header.taken, this.start = header.start;
    this.fit(header);
    // Most scenes have z upwards; the true cameras, which are held upright, know better.
    const upright = header.views.map(v => v.camera.axes[1]);
    if (header.start) upright.push(header.start.camera.axes[1]);
    const sum = upright.reduce((s, up) => add(s, up), [0, 0, 1e-3]);
    this.up = [0, 0, 1];
    for (let a = 0; a < 3; ++a) {
      const others = sum.map((v, i) => (i === a ? 0 : Math.abs(v)));
      if (Math.abs(sum[a]) > 2 * Math.max(...others))
        this.up = [0, 1, 2].map(i => (i === a ? Math.sign(sum[a]) : 0));
    }
    this.home();
  }

  /// Takes the box of a model.
  fit({box}) {
    this.box = box;
    this.centre = add(box.lo, box.hi).map(v => v / 2);
    const across = add(box.hi, box.lo, -1);
    this.diagonal = Math.sqrt(dot(across, across));
  }

  /// Where the page begins if that is no true picture's place; else as `splinevox render --camera orbit`
  /// begins: all of the box is seen.
  home() {
    if (this.start && this.start.view < 0) return this.take(this.start.camera);
    const half = 18 * Math.PI / 180, tilt = 20 * Math.PI / 180;
    const side = unit(cross(this.up, Math.abs(this.up[0]) > 0.5 ? [0, 1, 0] : [1, 0, 0]));
    const front = cross(side, this.up);
    const out = add(front.map(v => v * Math.cos(tilt)), this.up, Math.sin(tilt));
    this.axes = [unit(cross(this.up, out)), [], out];
    this.axes[1] = cross(out, this.axes[0]);
    this.pivot = this.centre;
    this.distance = 0.5 * this.diagonal / Math.sin(half);
    const focal = 200 / Math.tan(half);
    this.lens = {width: 400, height: 400, fx: focal, fy: focal, cx: 200, cy: 200};
  }

  /// A true camera; it turns about the point of its axis next to the middle of the box.
  take(camera) {
    this.axes = camera.axes.map(a => [...a]);
    this.lens = camera;
    this.distance = Math.max(dot(add(camera.position, this.centre, -1), this.axes[2]), 0.1 * this.diagonal);
    this.pivot = add(camera.position, this.axes[2], -this.distance);
  }

  get position() { return add(this.pivot, this.axes[2], this.distance); }

  /// How far the eye is from where pictures were taken: 0 near there, 1 where no picture tells anything.
  get away() {
    if (!this.taken) return 0;
    const {middle, directions, near, far, spacing} = this.taken;
    const from = add(this.position, middle, -1), distance = Math.max(Math.sqrt(dot(from, from)), 1e-9);
    const cosine = Math.max(...directions.map(d => dot(d, from) / distance));
    const angle = Math.acos(Math.max(-1, Math.min(1, cosine))) - Math.max(kFree, spacing);
    const ratio = Math.max(kNearer * near / distance, kNearer * distance / far);
    return Math.max(0, Math.min(1, Math.max(angle / kSoft, Math.log(ratio) / Math.log(kSoftRatio))));
  }
  /// Makes a change as large as the eye may go: ever less on the way away, all of it on the way back.
  /// @param change  of a share 0..1
  softly(change) {
    const {axes, pivot, distance} = this, before = this.away;
    change(1);
    for (let share = 1 - before, tries = 0; this.away > before && tries < 8; share /= 2, ++tries) {
      Object.assign(this, {axes, pivot, distance});
      change(share);
      if (this.away < 1) return;
    }
  }

  turn(yaw, pitch) { this.softly(share => this.turnBy(share * yaw, share * pitch)); }
  turnBy(yaw, pitch) {
    const height = Math.acos(Math.max(-1, Math.min(1, dot(this.axes[2], this.up)))), room = 0.03;
    pitch = Math.max(Math.min(pitch, Math.max(0, Math.PI - room - height)), Math.min(0, room - height));
    const right = this.axes[0];
    this.axes = this.axes.map(a => turned(turned(a, right, pitch), this.up, -yaw));
  }

  zoom(factor) {
    this.softly(share => {
      const wanted = this.distance * factor ** share;
      this.distance = Math.max(0.02 * this.diagonal, Math.min(20 * this.diagonal, wanted));
    });
  }

  /// Moves the scene by pixels of a pane of this size.
  pan(dx, dy, width, height) {
    const shown = Math.min(width / this.lens.width, height / this.lens.height);
    const scale = this.distance / (this.lens.fy * shown);
    this.softly(share => {
      this.pivot =
        add(add(this.pivot, this.axes[0], -share * dx * scale), this.axes[1], share * dy * scale);
    });
  }

  /// 1 / fx, 1 / fy, cx, cy for a pane: the picture of the lens, as large as fits.
  fitted(width, height) {
    const l = this.lens, s = Math.min(width / l.width, height / l.height);
    const cx = 0.5 * (width - l.width * s) + l.cx * s, cy = 0.5 * (height - l.height * s) + l.cy * s;
    return [1 / (l.fx * s), 1 / (l.fy * s), cx, cy];
  }

  /// Depth of the nearest and the farthest corner of the box.
  depthRange() {
    let near = 1e30, far = 0;
    for (let corner = 0; corner < 8; ++corner) {
      const p = [0, 1, 2].map(a => this.box[corner >> a & 1 ? "hi" : "lo"][a]);
      const depth = -dot(add(p, this.position, -1), this.axes[2]);
      near = Math.min(near, depth), far = Math.max(far, depth);
    }
    return [Math.max(near, 0), far];
  }
}
