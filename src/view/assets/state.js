// What is shown, and how it is written behind the # of the address:
// #t=0.5&view=3&layer=depth&compare=1&play=0&speed=1&background=ffffff&ui=1

const kSpeeds = [0.25, 0.5, 1, 2];
const kSecondsPerLoop = 4;  // at speed 1

const hexOfOne = v => Math.round(255 * Math.min(1, Math.max(0, v))).toString(16).padStart(2, "0");
const hexOf = c => c.map(hexOfOne).join("");
const colourOf = hex => [0, 2, 4].map(i => parseInt(hex.slice(i, i + 2), 16) / 255);

const kNight = "0d1117";
const night = matchMedia("(prefers-color-scheme: dark)");

/// What is behind the scene if nobody chose a colour: the model's, but dark where the page is and pictures
/// say where nothing is.
function ownBackground({background, background_harmonics, clear}) {
  const bright = background.reduce((sum, v) => sum + v) > 1.5;
  return night.matches && clear && bright && !background_harmonics.length ? colourOf(kNight) : background;
}

class State {
  constructor(header) {
    this.layer = "rgb";
    this.show(header);
    this.time = header.start?.time ?? 0;
    this.view = this.first;
    this.compare = false;
    this.playing = false;
    this.speed = 1;
    this.picked = null;  // background that somebody chose
    this.ui = true;
    this.loop();
  }

  /// Takes a model, the first or another one.
  show(header) {
    this.header = header;
    const motion = header.motion;
    const has = {
      rgb: true, depth: true, flow: motion && motion.displaces, rigidity: motion && motion.rigidity,
      cluster: header.clusters
    };
    this.layers = Object.keys(kLayers).filter(l => has[l]);
    if (!this.layers.includes(this.layer)) this.layer = "rgb";
  }

  /// The view that a page begins with; -1: the free camera.
  get first() { return this.header.start?.view ?? -1; }

  get background() { return this.picked ?? ownBackground(this.header); }

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
    if (/^[0-9a-f]{6}$/i.test(background)) this.picked = colourOf(background);
    if (given.has("ui")) this.ui = given.get("ui") !== "0";
    return named;
  }

  write() {
    const parts = [`t=${+this.time.toFixed(4)}`, `view=${this.view}`, `layer=${this.layer}`];
    if (this.compare) parts.push("compare=1");
    if (this.playing) parts.push("play=1");
    if (this.speed !== 1) parts.push(`speed=${this.speed}`);
    if (this.picked) parts.push("background=" + hexOf(this.picked));
    if (!this.ui) parts.push("ui=0");
    return "#" + parts.join("&");
  }

  /// From now on time goes round without an end.
  loop() { this.left = Infinity; }
  /// Plays all of time once, from a moment on, and rests at another.
  playOnce(from, rest) { Object.assign(this, {time: from, rest, left: 1, playing: true}); }
  /// Lets time go on. @param seconds  since the last call
  advance(seconds) {
    const share = seconds * this.speed / kSecondsPerLoop;
    this.left -= share;
    this.time = (this.time + share) % 1;
    if (this.left > 0) return;
    this.time = this.rest, this.playing = false;
    this.loop();
  }

  get look() { return {time: this.time, layer: this.layer, background: this.background}; }
}
