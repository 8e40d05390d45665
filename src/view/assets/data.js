// From the text of the page to numbers. docs/formats.md, "The page of view", says what is where.

async function inflated(text) {
  if (typeof DecompressionStream === "undefined")
    throw new Error("This browser cannot unpack the page's data (DecompressionStream). " +
      "Chrome 80, Firefox 113, Safari 16.4 and later can.");
  const packed = atob(text.trim()), bytes = new Uint8Array(packed.length);
  for (let i = 0; i < packed.length; ++i) bytes[i] = packed.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/// Differences with the sign in the lowest bit, back to numbers.
/// @param Numbers  Uint16Array, or Int16Array where they are signed.
function readPlane(bytes, plane, Numbers = Uint16Array) {
  const {offset, count, bits} = plane, wide = bits > 8, mask = wide ? 0xffff : 0xff;
  const out = new Numbers(count);
  let last = 0;
  for (let i = 0; i < count; ++i) {
    const folded = bytes[offset + i] | (wide ? bytes[offset + count + i] << 8 : 0);
    last = (last + ((folded >>> 1) ^ -(folded & 1))) & mask;
    out[i] = last;
  }
  return out;
}

/// [bricks * 3] places of bricks in the ring, x y z of each.
function readPlaces(bytes, field) {
  const planes = readPlane(bytes, field.places), n = field.bricks, out = new Uint16Array(3 * n);
  for (let i = 0; i < n; ++i) for (let a = 0; a < 3; ++a) out[3 * i + a] = planes[a * n + i];
  return out;
}

/// Number + 1 of the brick at every place of the ring, 0 = absent; x fastest, as textures are.
function brickTable(field, places) {
  const [dx, dy, dz] = field.dims, table = new Uint32Array(dx * dy * dz);
  for (let i = 0; i < field.bricks; ++i) {
    const [x, y, z] = places.subarray(3 * i, 3 * i + 3);
    table[(z * dy + y) * dx + x] = i + 1;
  }
  return table;
}

/// Where each brick's 9^3 texels go: the brick and the first vertices of its neighbours, so that a cell never
/// leaves its brick.
function atlasLayout(bricks, largest) {
  const most = Math.min(255, Math.floor(largest / 9));
  const edge = Math.min(most, Math.max(1, Math.ceil(Math.cbrt(bricks))));
  const layers = Math.max(1, Math.ceil(bricks / (edge * edge)));
  if (layers > most)
    throw new Error(`The model has ${bricks} bricks, more than this graphics card's textures hold. ` +
      "A page made with a smaller --max-mb has fewer.");
  return {edge, layers, size: [9 * edge, 9 * edge, 9 * layers]};
}

/// Calls put(values, z) for every layer of bricks of the atlas: [9 edge * 9 edge * 9 * width] values, the
/// first texel's z.
/// @param columns  of the brick rows, each {numbers, value(q), background}; width of a texel at least their
/// number.
function fillAtlas(field, places, table, layout, columns, width, Values, put) {
  const [dx, dy, dz] = field.dims, n = 9 * layout.edge, perLayer = layout.edge * layout.edge;
  const slab = new Values(n * n * 9 * width);
  for (let layer = 0; layer < layout.layers; ++layer) {
    slab.fill(0);
    for (let i = layer * perLayer; i < Math.min(field.bricks, (layer + 1) * perLayer); ++i) {
      const px = 9 * (i % layout.edge), py = 9 * (Math.floor(i / layout.edge) % layout.edge);
      for (let corner = 0; corner < 8; ++corner) {
        // The eight bricks this one's texels come from: itself and those behind its last vertices.
        const cx = corner & 1, cy = corner >> 1 & 1, cz = corner >> 2;
        const slot = ((places[3 * i + 2] + cz) * dy + places[3 * i + 1] + cy) * dx + places[3 * i] + cx;
        const inside = places[3 * i] + cx < dx && places[3 * i + 1] + cy < dy && places[3 * i + 2] + cz < dz;
        const from = inside ? table[slot] - 1 : -1;
        for (let x = cx ? 8 : 0; x < (cx ? 9 : 8); ++x)
          for (let y = cy ? 8 : 0; y < (cy ? 9 : 8); ++y)
            for (let z = cz ? 8 : 0; z < (cz ? 9 : 8); ++z) {
              const to = ((z * n + py + y) * n + px + x) * width;
              const row = from * 512 + (x & 7) * 64 + (y & 7) * 8 + (z & 7);
              for (let c = 0; c < columns.length; ++c) {
                const column = columns[c];
                slab[to + c] = from < 0 ? column.background : column.value(column.numbers[row]);
              }
            }
      }
    }
    put(slab, 9 * layer);
  }
}
