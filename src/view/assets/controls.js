// Hands: pointers, keys and the panel. All of it changes the state or the camera and then says so.

const $ = id => document.getElementById(id);

/// One pointer turns, two (or the right button, or shift) move and zoom, the wheel zooms.
function bindPointers(element, camera, moved) {
  const fingers = new Map();
  const spread = () => {
    const [a, b] = [...fingers.values()];
    return {x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, distance: Math.hypot(a.x - b.x, a.y - b.y)};
  };
  element.addEventListener("pointerdown", e => {
    element.setPointerCapture(e.pointerId);
    fingers.set(e.pointerId, {x: e.clientX, y: e.clientY});
  });
  element.addEventListener("pointermove", e => {
    const last = fingers.get(e.pointerId);
    if (!last) return;
    const two = fingers.size === 2 && spread(), dx = e.clientX - last.x, dy = e.clientY - last.y;
    fingers.set(e.pointerId, {x: e.clientX, y: e.clientY});
    const {width, height} = element.getBoundingClientRect();
    if (two) {
      const now = spread();
      camera.pan(now.x - two.x, now.y - two.y, width, height);
      if (now.distance > 0) camera.zoom(two.distance / now.distance);
    } else if (e.shiftKey || e.buttons & 6) camera.pan(dx, dy, width, height);
    else camera.turn(dx * 0.008, -dy * 0.008);
    moved();
  });
  for (const end of ["pointerup", "pointercancel"])
    element.addEventListener(end, e => fingers.delete(e.pointerId));
  element.addEventListener("wheel", e => {
    e.preventDefault();
    camera.zoom(Math.exp(Math.max(-0.5, Math.min(0.5, e.deltaY * (e.deltaMode ? 0.05 : 0.0015)))));
    moved();
  }, {passive: false});
  element.addEventListener("contextmenu", e => e.preventDefault());
}

/// A button for each layer that the model has.
function showLayers(app) {
  const {layers} = app.state;
  const shown = [...$("layers").children].map(button => button.dataset.layer);
  if (shown.join() === layers.join()) return;  // the same buttons keep focus and clicks
  $("layers").replaceChildren(...layers.map(layer => {
    const button = document.createElement("button");
    button.textContent = kLayers[layer].label, button.title = kLayers[layer].says;
    button.dataset.layer = layer;
    button.setAttribute("role", "radio");
    button.addEventListener("click", () => app.set({layer}));
    return button;
  }));
  $("layers").hidden = layers.length < 2;
}

/// The panel and the keys. @param app  main.js
function bindPanel(app) {
  const {state, header} = app;
  showLayers(app);
  header.views.forEach((view, i) => {
    const button = document.createElement("button"), picture = new Image();
    picture.src = view.picture, picture.alt = "";
    const label = document.createElement("span");
    label.textContent = view.time.toFixed(2);
    const when = `time ${view.time.toFixed(3)}`;
    button.title = `${app.nameOf(view)}, ${when}: look from where this picture was taken`;
    button.setAttribute("aria-label", button.title);
    button.append(picture, label);
    button.addEventListener("click", () => app.goTo(i));
    $("views").append(button);
  });
  $("views").hidden = $("compare").hidden = header.views.length === 0;
  $("play").addEventListener("click", () => app.set({playing: !state.playing}));
  $("time").addEventListener("input", e => app.set({time: Number(e.target.value), playing: false}));
  $("speed").addEventListener("change", e => app.set({speed: Number(e.target.value)}));
  $("compare").addEventListener("click", () => app.compare());
  $("reset").addEventListener("click", () => app.reset());
  $("quality").addEventListener("change", e => {
    app.painter.quality = e.target.value;
    app.painter.invalidate();
  });
  $("background").addEventListener("input", e => app.set({picked: colourOf(e.target.value.slice(1))}));
  $("save").addEventListener("click", () => app.save());
  $("record").hidden = !filmType() || !header.motion;
  $("record").addEventListener("click", () => app.record());
  $("full").hidden = !document.fullscreenEnabled;
  $("full").addEventListener("click", () => app.fullScreen());
  night.addEventListener("change", () => app.set({}));
  $("note").textContent = header.note;
  document.addEventListener("keydown", e => {
    if (e.ctrlKey || e.metaKey || e.altKey || e.target.closest("select, input[type=color]")) return;
    const button = e.target.closest("button, summary, input[type=checkbox]");
    const slider = e.target.closest("input");
    const step = e.shiftKey ? 0.1 : 0.01;
    const keys = {
      " ": () => { if (button) return false; app.set({playing: !state.playing}); },
      ArrowLeft: () => {
        if (slider) return false;
        app.set({time: Math.max(0, state.time - step), playing: false});
      },
      ArrowRight: () => {
        if (slider) return false;
        app.set({time: Math.min(1, state.time + step), playing: false});
      },
      "+": () => app.nudge(0, 0, 0.9), "=": () => app.nudge(0, 0, 0.9), "-": () => app.nudge(0, 0, 1.1),
      a: () => app.nudge(0.1, 0, 1), d: () => app.nudge(-0.1, 0, 1),
      w: () => app.nudge(0, -0.1, 1), s: () => app.nudge(0, 0.1, 1),
      c: () => app.compare(), f: () => app.fullScreen(),
      r: () => app.reset(), h: () => app.set({ui: !state.ui}),
    };
    state.layers.forEach((layer, i) => { keys[String(i + 1)] = () => app.set({layer}); });
    if (keys[e.key] && keys[e.key]() !== false) e.preventDefault();
  });
}

/// The panel says what the state is.
function showState(app) {
  const {state, header} = app, map = header.time;
  document.body.classList.toggle("bare", !state.ui);
  document.body.classList.toggle("compared", state.compare);
  $("play").setAttribute("aria-pressed", state.playing);
  $("play").setAttribute("aria-label", state.playing ? "pause" : "play");
  $("time").value = state.time;
  const own = map.scale ? state.time / map.scale + map.origin : map.origin;
  $("clock").textContent = state.time.toFixed(3);
  $("clock").title = `time of the data: ${own.toFixed(3)}`;
  const away = state.view < 0 ? app.camera.away : 0;  // a true picture is where one was taken
  $("canvas").style.filter = away > 0 ? `saturate(${1 - away}) opacity(${1 - 0.75 * away})` : "";
  $("far").hidden = away < 0.25;
  $("speed").value = String(state.speed);
  for (const b of $("layers").children) b.setAttribute("aria-checked", b.dataset.layer === state.layer);
  [...$("views").children].forEach((b, i) => b.setAttribute("aria-pressed", i === state.view));
  $("compare").setAttribute("aria-pressed", state.compare);
  $("background").value = "#" + hexOf(state.background);
  document.body.style.setProperty("--behind", "#" + hexOf(state.background));
  $("record").setAttribute("aria-pressed", !!app.recorder);
  showLegend(state.layer, {depthRange: app.camera.depthRange(), fullFlow: header.full_flow});
  if (state.compare) {
    const view = header.views[app.compared], picture = $("truth").querySelector("img");
    if (picture.src !== view.picture) picture.src = view.picture;
    picture.alt = `true picture, ${app.nameOf(view)}`;
    const apart = [];
    if (state.view !== app.compared) apart.push("the camera has moved");
    if (Math.abs(state.time - view.time) > 1e-3) apart.push(`it was taken at ${view.time.toFixed(3)}`);
    $("truth").querySelector("figcaption").textContent =
      `truth: ${app.nameOf(view)}` + (apart.length ? `; ${apart.join(", ")}` : "");
  }
}
