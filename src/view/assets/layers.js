// What the layers show: their names for a reader, their colours, and what a colour stands for. The names in
// addresses and model files are the keys.

const kLayers = {
  rgb: {label: "colour", says: "colour, as pictures show it"},
  depth: {label: "depth", says: "distance along the viewing axis"},
  flow: {
    label: "displacement",
    says: "the way from a place to where it looks in the canonical volume: its direction as colour, " +
      "its length as strength; model files and options call it flow"
  },
  rigidity: {
    label: "moves",
    says: "the learned share of motion, 0 stays and 1 moves; model files and options call it rigidity"
  },
  cluster: {label: "parts", says: "parts of the model by how they move"}
};

// Colours of equal distance, as in run/colours.cpp.
const kDepthColours = [
  [0.99, 0.91, 0.14], [0.37, 0.79, 0.38], [0.13, 0.57, 0.55], [0.23, 0.32, 0.55], [0.27, 0, 0.33]];
const kMovesColours = [[0.16, 0.29, 0.62], [0.87, 0.87, 0.87], [0.75, 0.15, 0.12]];

const arrayOf = (name, colours) => {
  const list = colours.map(c => `vec3(${c.map(v => v.toFixed(3))})`);
  return `const vec3 ${name}[${list.length}] = vec3[](${list});\n`;
};
const kColourSource = arrayOf("kDepth", kDepthColours) + arrayOf("kMoves", kMovesColours);

/// The bars of a layer: what stands before each, its colours, and the texts below it; none: it needs none.
/// @param look  depthRange [near, far] and fullFlow, scene units
function legendOf(layer, {depthRange, fullFlow}) {
  const three = v => String(Number(v.toPrecision(3))), unit = "scene units";
  if (layer === "depth")
    return {bars: [["", kDepthColours]], ends: [three(depthRange[0]), unit, three(depthRange[1])]};
  if (layer === "rigidity") return {bars: [["", kMovesColours]], ends: ["0 stays", "", "1 moves"]};
  if (layer !== "flow") return null;
  const along = axis => [0, 0.5, 1].map(v => [0, 1, 2].map(a => (a === axis ? v : 0.5)));
  const full = three(fullFlow);
  const bars = ["x", "y", "z"].map((name, a) => [name, along(a)]);
  return {bars, ends: [`\u2212${full}`, unit, `+${full}`]};
}

/// The legend of what is shown.
function showLegend(layer, look) {
  const box = $("legend"), legend = legendOf(layer, look), key = JSON.stringify(legend);
  if (box.dataset.key === key) return;
  box.dataset.key = key;
  box.hidden = !legend;
  if (!legend) return;
  const element = (tag, text, className = "") =>
    Object.assign(document.createElement(tag), {textContent: text, className});
  const rgb = c => `rgb(${c.map(v => Math.round(255 * v))})`;
  const rows = legend.bars.map(([name, colours]) => {
    const row = element("div", name, "bar"), bar = document.createElement("i");
    bar.style.background = `linear-gradient(90deg, ${colours.map(rgb)})`;
    row.append(bar);
    return row;
  });
  const ends = element("div", "", "ends");
  ends.append(...legend.ends.map(text => element("span", text)));
  box.replaceChildren(element("b", kLayers[layer].label), ...rows, ends);
}
