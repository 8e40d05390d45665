// The page of `train --live`: asks how far the training is, shows it, and says what is wished for. What is
// asked and answered is in docs/formats.md, "The live page". window.splinevox resolves to the App once there
// is a model; window.live is what tests may use.

const kAskEvery = 1000, kAskHidden = 5000;  // milliseconds
const kSure = 4000;                         // for which a second press stops
const kMostPoints = 600, kManyDots = 60;    // of a curve

const timeText = seconds => {
  const s = Math.round(seconds), pad = n => String(n).padStart(2, "0");
  return s < 3600 ? `${Math.floor(s / 60)}:${pad(s % 60)}`
    : `${Math.floor(s / 3600)}:${pad(Math.floor(s / 60) % 60)}:${pad(s % 60)}`;
};

class Live {
  constructor() {
    this.lines = this.notes = 0;
    this.shown = -1;         // step of the model on the stage
    this.views = [];         // previews: {step, psnr}
    this.about = {};
    this.last = {};          // line of metrics.jsonl
    this.held = null;        // PSNR of the held-out view
    this.asking = this.again = this.lost = false;
    this.start = null;       // seconds of the first line: what came before belongs to no step
    this.ready = new Promise(resolve => { this.resolve = resolve; });
    this.charts = [...document.querySelectorAll("#live canvas")].map(c => Chart.getChart(c));
    $("wait").textContent = "The model is shown here once it has made some steps.";
    $("pause").addEventListener("click", () => this.wish(this.paused ? "go" : "pause"));
    $("add").addEventListener("click", () => this.wish("more?seconds=" + $("seconds").value));
    $("stop").addEventListener("click", () => this.stop());
    $("past").addEventListener("input", () => this.showPreview());
    document.addEventListener("visibilitychange", () => { if (!document.hidden) this.askSoon(0); });
    this.askSoon(0);
  }

  askSoon(milliseconds) {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.ask(), milliseconds);
  }

  /// One question at a time: two answers to the same one would count their lines twice.
  async ask() {
    this.again = this.asking;
    if (this.asking) return;
    this.asking = true;
    const next = await this.askNow();
    this.asking = false;
    if (next !== null) this.askSoon(this.again && !this.lost ? 0 : next);
  }

  /// Resolves to the milliseconds until it should be asked again; null: nothing more is to come.
  async askNow() {
    const follow = $("follow").checked && !document.hidden ? 1 : 0;
    try {
      const answer = await fetch(`state?lines=${this.lines}&notes=${this.notes}&follow=${follow}`);
      if (!answer.ok) throw new Error(answer.status);
      const state = await answer.json();
      this.take(state);
      if (this.lost) this.tell("");
      this.lost = false;
      this.disable(this.over);
      if (follow && state.model > this.shown) await this.fetchModel();
      if (!this.over) return document.hidden ? kAskHidden : kAskEvery;
      this.final = !follow || state.model >= (this.last.step ?? 0);  // else the last model is on its way
      return this.final ? null : 200;
    } catch (e) {
      if (this.over) return null;
      this.lost = true;
      this.tell(this.given_up ? "Stopped before the first step: nothing is saved."
        : "The training cannot be reached just now. It may have ended.");
      this.disable(true);
      return kAskHidden;
    }
  }

  async fetchModel() {
    const answer = await fetch("model");
    if (!answer.ok) return;
    const buffer = await answer.arrayBuffer();
    const length = new DataView(buffer).getUint32(0, true);
    const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
    const bytes = new Uint8Array(buffer, 4 + length);
    try {
      if (this.app) {
        this.app.replace(header, bytes);
      } else {
        this.app = new App(header, bytes);
        this.resolve(this.app);
      }
    } catch (e) {
      complain(e.message);
      $("follow").checked = false;
    }
    this.shown = header.step_of_training;
    $("shown").textContent = `(step ${this.shown})`;
  }

  take(state) {
    if (state.about) this.takeAbout(state.about);
    for (const note of state.notes) {
      const item = document.createElement("li");
      item.textContent = note;
      $("log").append(item);
    }
    this.notes += state.notes.length;
    for (const line of state.lines) this.takeLine(line);
    this.lines += state.lines.length;
    if (state.lines.length) this.charts.forEach(c => c.update("none"));
    this.showState(state);
  }

  takeAbout(about) {
    this.about = about;
    if (!about.folder) return;
    $("about").textContent = `${about.dataset}, preset ${about.preset}`;
    $("longer").hidden = !about.by_clock;
    $("true-text").textContent = `truth: ${about.of_training ? "train" : "val"} view ${about.view}`;
    const effects = about.effects?.effects ?? [];
    $("effects").hidden = effects.length === 0;
    $("chips").replaceChildren(...effects.map(e => {
      const chip = document.createElement("li");
      const gain = typeof e.gain_db === "number"
        ? ` ${e.gain_db < 0 ? "\u2212" : "+"}${Math.abs(e.gain_db).toFixed(2)} dB` : "";
      chip.textContent = (e.used ? "" : "without ") + e.effect + gain;
      chip.className = e.used ? "used" : "";
      return chip;
    }));
  }

  takeLine(line) {
    // Others are of a wish that was heard, or of a step that was discarded.
    if (line.held_view === undefined && line.loss === undefined) return;
    this.start ??= line.seconds;
    const x = line.seconds - this.start, [psnr, loss] = this.charts.map(c => c.data.datasets);
    if (line.held_view !== undefined) {
      this.held = line.held_psnr;
      psnr[1].data.push({x, y: line.held_psnr});
      this.views.push({step: line.step, psnr: line.held_psnr});
      this.addPreview();
    } else {
      this.last = line;
      psnr[0].data.push({x, y: line.psnr});
      loss[0].data.push({x, y: line.loss});
    }
    for (const set of [psnr[0], psnr[1], loss[0]])
      if (set.data.length > kMostPoints) set.data = set.data.filter((_, i) => i % 2 === 0);
    if (psnr[1].data.length > kManyDots) psnr[1].pointRadius = 1.2;
  }

  addPreview() {
    const slider = $("past"), atEnd = slider.value === slider.max;
    $("previews").hidden = false;
    slider.max = this.views.length - 1;
    slider.hidden = this.views.length < 2;
    if (atEnd) slider.value = slider.max;
    if (!$("true").src) $("true").src = "truth.png";
    this.showPreview();
  }
  showPreview() {
    const view = this.views[Number($("past").value)];
    const src = `preview/step_${String(view.step).padStart(6, "0")}.png`;
    if ($("now").getAttribute("src") !== src) $("now").src = src;
    $("now-text").textContent = `step ${view.step}: ${view.psnr.toFixed(1)} dB`;
  }

  showState(state) {
    this.paused = state.paused;
    this.over = state.phase === "saved" || state.phase === "finished";
    this.given_up = state.phase === "preparing" && state.stopping;
    const going = state.phase === "training";
    $("phase").textContent = state.phase === "finished" ? "Finished and saved"
      : state.phase === "saved" ? "Stopped and saved" : state.phase === "saving" ? "Saving\u2026"
      : state.stopping ? "Stopping\u2026"
      : !going ? "Preparing\u2026" : state.paused ? "Paused" : "Training";
    const {step, seconds, progress} = this.last;
    $("share").value = progress ?? 0;
    const parts = [];
    if (step !== undefined) parts.push(`step ${step}`, `${Math.round(100 * progress)}%`);
    if (seconds !== undefined)
      parts.push(timeText(seconds) + (this.about.by_clock ? ` of ${timeText(state.max_time)}` : ""));
    if (going && state.left !== null) parts.push(`${timeText(state.left)} left`);
    $("where").textContent = this.over && this.about.folder
      ? `${parts.join(" \u00b7 ")} \u00b7 in ${this.about.folder}` : parts.join(" \u00b7 ");
    $("pause").textContent = state.paused ? "Go on" : "Pause";
    $("pause").setAttribute("aria-pressed", state.paused);
    const {psnr, loss, rays_per_second} = this.last, figures = [];
    if (this.held !== null) {
      figures.push([this.held.toFixed(1) + " dB", this.about.of_training ? "train view" : "held-out"]);
    }
    if (psnr !== undefined)
      figures.push([psnr.toFixed(1) + " dB", "rays"], [loss.toExponential(1), "loss"],
        [Math.round(rays_per_second / 1000) + " k/s", "rays a second"]);
    $("figures").replaceChildren(...figures.map(([value, name]) => {
      const pair = document.createElement("div"), dt = document.createElement("dt"),
        dd = document.createElement("dd");
      dt.textContent = name, dd.textContent = value;
      pair.append(dt, dd);
      return pair;
    }));
  }

  async wish(what) {
    try {
      const answer = await fetch(what, {method: "POST"});
      this.tell(answer.ok ? "" : await answer.text());
    } catch (e) {
      this.tell("The training cannot be reached.");
    }
    this.askSoon(100);
  }
  /// The second press stops: the first may be a slip.
  stop() {
    const button = $("stop"), sure = button.classList.contains("sure");
    button.classList.toggle("sure", !sure);
    button.textContent = sure ? "Stop and save" : "Press again to stop";
    clearTimeout(this.slip);
    if (sure) return this.wish("stop");
    this.slip = setTimeout(() => {
      button.classList.remove("sure");
      button.textContent = "Stop and save";
    }, kSure);
  }
  tell(text) {
    $("answer").textContent = text;
    $("answer").hidden = !text;
  }
  disable(off) {
    for (const e of document.querySelectorAll("#wishes button, #wishes select, #follow")) e.disabled = off;
  }
}

window.live = new Live();
window.splinevox = window.live.ready;
