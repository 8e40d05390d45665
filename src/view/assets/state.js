// What is shown, and how it is written behind the # of the address:
// #t=0.5&view=3&layer=depth&compare=1&play=0&speed=1&background=ffffff&ui=1

const kSpeeds = [0.25, 0.5, 1, 2];
const kSecondsPerLoop = 4;  // at speed 1

const hexOfOne = v => Math.round(255 * Math.min(1, Math.max(0, v))).toString(16).padStart(2, "0");
const hexOf = c => c.map(hexOfOne).join("");
const colourOf = hex => [0, 2, 4].map(i => parseInt(hex.slice(i, i + 2), 16) / 255);

class State {
  constructor(header) {
    this.layer = "rgb";
    this.show(header);
    this.time = 0;
    this.view = this.first;
    this.compare = false;
    this.playing = false;
    this.speed = 1;
    this.background = header.background;
    this.ui = true;
    if (this.view === 0) this.time = header.views[0].time;
    if (header.taken) this.time = header.taken.start.time;
  }

  /// Takes a model, the first or another one.
  show(header) {
    this.header = header;
    const motion = header.motion;
    const has = {
      rgb: true, depth: true, flow: motion && motion.displaces, rigidity: motion && motion.rigidity,
      cluster: header.clusters
    };
    this.layers = kLayers.filter(l => has[l]);
    if (!this.layers.includes(this.layer)) this.layer = "rgb";
  }

  /// The view that a page begins with: where pictures are on one side, the free camera, at a training camera.
  get first() { return this.header.views.length && !this.header.taken ? 0 : -1; }

  /// Takes what an address says; what it does not say, or says wrongly, stays.
  /// True if it names a view or the free camera.
  read(hash) {
    const given = new URLSearchParams(hash.replace(/^#/, ""));
    const number = key => (given.has(key) ? Number(given.get(key)) : NaN);
    const view = number("view");
    const named = Number.isInteger(view) && view >= -1 && view < this.header.views.length;
    if (named) {
      this.view = view;
      if (view >= 0) this.time = this.header.views[view].time;
    }
    if (Number.isFinite(number("t"))) this.time = Math.min(1, Math.max(0, number("t")));
    if (this.layers.includes(given.get("layer"))) this.layer = given.get("layer");
    if (given.has("compare")) this.compare = given.get("compare") === "1" && this.header.views.length > 0;
    if (given.has("play")) this.playing = given.get("play") === "1";
    if (kSpeeds.includes(number("speed"))) this.speed = number("speed");
    const background = given.get("background") || "";
    if (/^[0-9a-f]{6}$/i.test(background)) this.background = colourOf(background);
    if (given.has("ui")) this.ui = given.get("ui") !== "0";
    return named;
  }

  write() {
    const parts = [`t=${+this.time.toFixed(4)}`, `view=${this.view}`, `layer=${this.layer}`];
    if (this.compare) parts.push("compare=1");
    if (this.playing) parts.push("play=1");
    if (this.speed !== 1) parts.push(`speed=${this.speed}`);
    const background = hexOf(this.background);
    if (background !== hexOf(this.header.background)) parts.push("background=" + background);
    if (!this.ui) parts.push("ui=0");
    return "#" + parts.join("&");
  }

  /// Lets time go on. @param seconds  since the last call
  advance(seconds) { this.time = (this.time + seconds * this.speed / kSecondsPerLoop) % 1; }

  get look() { return {time: this.time, layer: this.layer, background: this.background}; }
}
