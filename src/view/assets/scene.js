// The model on the graphics card. setTime contracts the control points to one displacement a vertex, once per
// time and not per sample (the house decision "contract first"), and finds out which cells of observed space
// can hold matter then.

const kBlock = 4;  // cells an edge of the blocks that rays cross in one step

class Scene {
  constructor(gl, header, bytes) {
    this.gl = gl, this.header = header;
    this.largest = Math.min(2048, gl.getParameter(gl.MAX_3D_TEXTURE_SIZE));
    this.sliceBuffer = gl.createFramebuffer();
    const motion = header.motion;
    this.changes = !!motion, this.moves = !!motion && motion.displaces;
    this.scalars = motion ? motion.scalars : [];
    this.shOrder = header.radiance.sh_order;
    this.shTextures = this.shOrder < 0 ? 0 : Math.ceil((this.shOrder + 1) ** 2 / 4);
    const backgroundOrder = Math.sqrt(header.background_harmonics.length) - 1;
    this.defines = [
      `#define BACKGROUND_ORDER ${backgroundOrder}\n`,
      `#define CHANGES ${+this.changes}\n`,
      ...this.scalars.map((name, lane) => `#define ${name.toUpperCase()} ${"xyzw"[lane]}\n`),
      `#define RIGIDITY ${+(this.changes && motion.rigidity)}\n`,
      `#define SH_TEXTURES ${this.shTextures}\n`,
      `#define SH_ORDER ${this.shOrder}\n`,
      `#define PARTS ${+!!header.clusters}\n`,
      kColourSource, kTilesSource, kWarpSource
    ].join("");
    this.uploadRadiance(header.radiance, bytes);
    this.uploadOccupancy(header.occupancy, bytes);
    if (this.changes) this.uploadMotion(motion, bytes);
    if (header.clusters) this.uploadParts(header.clusters, bytes);
    this.time = NaN;
  }

  /// Gives back what it holds of the graphics card.
  free() {
    const {gl} = this;
    for (const texture of [this.bricks, this.atlas, ...this.harmonics, this.canonical, this.parts,
      this.motionTable, this.points, this.slice, this.sliceScalars]) gl.deleteTexture(texture ?? null);
    this.cells.free(), this.blocks.free();
    gl.deleteFramebuffer(this.sliceBuffer);
  }

  uploadRadiance(field, bytes) {
    const gl = this.gl, places = readPlaces(bytes, field), table = brickTable(field, places);
    const layout = atlasLayout(field.bricks, this.largest), n = layout.size[0];
    const where = new Uint8Array(4 * table.length);
    table.forEach((brick, slot) => {
      if (!brick) return;
      const i = brick - 1, e = layout.edge;
      where.set([i % e, Math.floor(i / e) % e, Math.floor(i / (e * e)), 1], 4 * slot);
    });
    this.bricks = texture3d(gl, gl.RGBA8UI, field.dims, gl.NEAREST);
    gl.texSubImage3D(gl.TEXTURE_3D, 0, 0, 0, 0, ...field.dims, gl.RGBA_INTEGER, gl.UNSIGNED_BYTE, where);
    const columns = field.columns.map(c => {
      const top = 2 ** c.plane.bits - 1;
      const numbers = readPlane(bytes, c.plane);
      return {numbers, lo: c.lo, range: c.hi - c.lo, top, background: c.background};
    });
    const raw = columns.slice(0, 4).map(c => ({...c, value: q => c.lo + q * c.range / c.top}));
    this.atlas = texture3d(gl, gl.RGBA16F, layout.size, gl.LINEAR);
    fillAtlas(field, places, table, layout, raw, 4, Float32Array, (values, z) =>
      gl.texSubImage3D(gl.TEXTURE_3D, 0, 0, 0, z, n, n, 9, gl.RGBA, gl.FLOAT, values));
    this.harmonics = [];
    for (let k = 0; k < this.shTextures; ++k) {
      const four = columns.slice(4 + 4 * k, 8 + 4 * k).map(c => ({
        ...c, value: q => Math.round(q * 255 / c.top),
        background: c.range > 0 ? Math.round((c.background - c.lo) / c.range * 255) : 0
      }));
      this.harmonicRange = [columns[4].lo, columns[4].range];
      const texture = texture3d(gl, gl.RGBA8, layout.size, gl.LINEAR);
      fillAtlas(field, places, table, layout, four, 4, Uint8Array, (values, z) =>
        gl.texSubImage3D(gl.TEXTURE_3D, 0, 0, 0, z, n, n, 9, gl.RGBA, gl.UNSIGNED_BYTE, values));
      this.harmonics.push(texture);
    }
  }

  uploadOccupancy(grid, bytes) {
    const gl = this.gl, [sx, sy, sz] = grid.size, cells = new Uint8Array(2 * sx * sy * sz);
    [grid.canonical, grid.ever || grid.canonical].forEach((plane, channel) => {
      const packed = readPlane(bytes, plane);
      for (let x = 0, i = 0; x < sx; ++x)
        for (let y = 0; y < sy; ++y)
          for (let z = 0; z < sz; ++z, ++i)
            cells[2 * ((z * sy + y) * sx + x) + channel] = packed[i >> 3] >> (i & 7) & 1 ? 255 : 0;
    });
    this.canonical = texture3d(gl, gl.RG8, grid.size, gl.NEAREST);
    gl.texSubImage3D(gl.TEXTURE_3D, 0, 0, 0, 0, sx, sy, sz, gl.RG, gl.UNSIGNED_BYTE, cells);
    this.blockSize = grid.size.map(n => Math.ceil(n / kBlock));
    this.cells = new Target(gl, gl.R8, gl.NEAREST), this.blocks = new Target(gl, gl.R8, gl.NEAREST);
    this.cells.resize(...tiledShape(grid.size)), this.blocks.resize(...tiledShape(this.blockSize));
    const shader = name => document.getElementById(name).textContent;
    this.occupancyPass = programOf(gl, this.defines + shader("occupancy.frag"));
    this.blocksPass = programOf(gl, kTilesSource + shader("blocks.frag"));
  }

  /// The colour of the part that each canonical cell belongs to; transparent where it belongs to none.
  uploadParts(clusters, bytes) {
    const gl = this.gl, [sx, sy, sz] = clusters.size, labels = readPlane(bytes, clusters.labels);
    const colours = new Uint8Array(4 * sx * sy * sz);
    for (let x = 0, i = 0; x < sx; ++x)
      for (let y = 0; y < sy; ++y)
        for (let z = 0; z < sz; ++z, ++i)
          if (labels[i]) {
            const colour = clusters.colours[labels[i] - 1].map(c => Math.round(255 * c));
            colours.set([...colour, 255], 4 * ((z * sy + y) * sx + x));
          }
    this.parts = texture3d(gl, gl.RGBA8, clusters.size, gl.NEAREST);
    gl.texSubImage3D(gl.TEXTURE_3D, 0, 0, 0, 0, sx, sy, sz, gl.RGBA, gl.UNSIGNED_BYTE, colours);
  }

  /// One long list of texels, number k of row r at k * rows + r: the control points, then a point of each
  /// curve of one number, then the rigidity.
  uploadMotion(motion, bytes) {
    const gl = this.gl, rows = motion.bricks * 512;
    this.rigidityNumber = (this.scalars.length ? 2 : 1) * motion.stored;
    const numbers = this.rigidityNumber + (motion.rigidity ? 1 : 0);
    const places = readPlaces(bytes, motion), table = brickTable(motion, places);
    this.motionTable = texture3d(gl, gl.R32UI, motion.dims, gl.NEAREST);
    gl.texSubImage3D(gl.TEXTURE_3D, 0, 0, 0, 0, ...motion.dims, gl.RED_INTEGER, gl.UNSIGNED_INT, table);
    const largest = gl.getParameter(gl.MAX_TEXTURE_SIZE);
    const width = Math.min(4096, largest), height = Math.max(1, Math.ceil(rows * numbers / width));
    if (height > largest) throw new Error("The model's motion is larger than this graphics card's textures.");
    const texels = new Int16Array(4 * width * height);
    const put = (number, lane, plane) => readPlane(bytes, plane, Int16Array).forEach((v, r) => {
      texels[4 * (number * rows + r) + lane] = v;
    });
    motion.control_points.forEach((p, k) => p.planes.forEach((plane, lane) => put(k, lane, plane)));
    this.scalars.forEach((name, lane) =>
      motion[`${name}_points`].forEach((p, k) => put(motion.stored + k, lane, p.planes[0])));
    if (motion.rigidity) put(this.rigidityNumber, 0, motion.rigidity_values.planes[0]);
    this.points = texture2d(gl, gl.RGBA16I, width, height, gl.NEAREST);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, gl.RGBA_INTEGER, gl.SHORT, texels);
    this.rows = rows;
    this.slice = texture3d(gl, gl.RGBA16F, motion.size, gl.LINEAR);
    this.sliceScalars = this.scalars.length ? texture3d(gl, gl.RGBA16F, motion.size, gl.LINEAR) : null;
    this.contractPass = programOf(gl, document.getElementById("contract.frag").textContent);
  }

  setTime(t) {
    if (t === this.time) return;
    const gl = this.gl, grid = this.header.occupancy;
    if (this.changes) this.contract(t);
    if (this.moves || Number.isNaN(this.time)) {
      const pass = this.occupancyPass.use();
      pass.texture("canonical", this.canonical);
      pass.vec3("gridOrigin", grid.origin), pass.vec3("boxHi", this.header.box.hi);
      pass.float("cell", grid.cell), pass.ivec3("gridSize", grid.size);
      this.bindWarp(pass);
      this.cells.begin();
      pass.draw();
      const blocks = this.blocksPass.use();
      blocks.texture("cells", this.cells.texture, gl.TEXTURE_2D);
      blocks.ivec3("gridSize", grid.size), blocks.ivec3("blockSize", this.blockSize);
      this.blocks.begin();
      blocks.draw();
    }
    this.time = t;
  }

  contract(t) {
    const motion = this.header.motion, all = storedWeights(motion, t), pass = this.contractPass.use();
    let first = 0, last = all.length;
    while (last > 0 && all[last - 1] === 0) --last;
    while (first < last && all[first] === 0) ++first;
    const weights = [], scalarWeights = new Float32Array(4 * (last - first));
    for (let k = first; k < last; ++k) {
      weights.push(motion.displaces ? all[k] * motion.control_points[k].scale : 0);
      this.scalars.forEach((name, lane) => {
        scalarWeights[4 * (k - first) + lane] = all[k] * motion[`${name}_points`][k].scale;
      });
    }
    pass.texture("table", this.motionTable);
    pass.texture("points", this.points, this.gl.TEXTURE_2D);
    pass.int("rows", this.rows), pass.int("first", first), pass.int("count", last - first);
    if (weights.length) pass.floats("weights", weights), pass.vec4("scalarWeights", scalarWeights);
    pass.int("scalarNumber", this.scalars.length ? motion.stored : -1);
    pass.int("rigidityNumber", motion.rigidity ? this.rigidityNumber : -1);
    pass.float("rigidityScale", motion.rigidity ? motion.rigidity_values.scale : 0);
    pass.float("rigidityBackground", motion.rigidity ? motion.rigidity_background : 0);
    const targets = this.sliceScalars ? [this.slice, this.sliceScalars] : [this.slice];
    drawLayers(this.gl, this.sliceBuffer, targets, motion.size, pass);
  }

  /// What motionAt reads.
  bindWarp(pass) {
    if (!this.changes) return;
    const motion = this.header.motion;
    pass.texture("slice", this.slice);
    if (this.sliceScalars) pass.texture("sliceScalars", this.sliceScalars);
    pass.vec3("motionOrigin", motion.origin.map(o => o + 8 * motion.spacing));
    pass.float("motionInverseSpacing", 1 / motion.spacing);
    pass.float("rigidityOffset", motion.rigidity_offset);
  }

  /// All that a ray needs but its camera.
  bindField(pass) {
    const {radiance, occupancy, box, background_harmonics} = this.header;
    pass.texture("bricks", this.bricks);
    pass.texture("atlas", this.atlas);
    this.harmonics.forEach((h, i) => pass.texture(`harmonics[${i}]`, h));
    if (this.harmonics.length) pass.vec2("harmonicRange", this.harmonicRange);
    if (this.parts) {
      const {origin, spacing} = this.header.clusters;
      pass.texture("parts", this.parts);
      pass.vec3("partOrigin", origin);
      pass.float("partInverseSpacing", 1 / spacing);
    }
    pass.texture("cells", this.cells.texture, this.gl.TEXTURE_2D);
    pass.texture("blocks", this.blocks.texture, this.gl.TEXTURE_2D);
    this.bindWarp(pass);
    pass.vec3("gridOrigin", occupancy.origin);
    pass.float("inverseCell", 1 / occupancy.cell);
    pass.ivec3("gridSize", occupancy.size);
    pass.ivec3("blockSize", this.blockSize);
    if (background_harmonics.length) pass.vec3("backgroundHarmonics", background_harmonics.flat());
    pass.vec3("boxLo", box.lo), pass.vec3("boxHi", box.hi);
    pass.vec3("ringOrigin", radiance.origin), pass.vec3("ringLimit", radiance.dims.map(d => 8 * d - 2));
    pass.float("inverseSpacing", 1 / radiance.spacing);
    pass.float("densityScale", radiance.scale), pass.float("densityShift", radiance.shift);
  }
}
