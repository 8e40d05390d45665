// SPDX-License-Identifier: Apache-2.0
// usd_read.mjs TINYUSDZ FOLDER : what TinyUSDZ (the folder of the npm package) makes of FOLDER/sequence.usda and
// the layers beside it, as one layer, on standard output; and how many meshes it would draw, on standard error.
import fs from "fs";
import path from "path";
import { pathToFileURL } from "url";

const [tiny, folder] = process.argv.slice(2);
// The package is made for browsers and their workers, and asks where it is.
process.type = "renderer";
globalThis.WorkerGlobalScope = class {};
globalThis.location = { href: "file:///" };
const { default: load } = await import(pathToFileURL(path.resolve(tiny, "tinyusdz.js")));
const native = await load({ wasmBinary: fs.readFileSync(path.join(tiny, "tinyusdz.wasm")) });
const bytes = (name) => new Uint8Array(fs.readFileSync(path.join(folder, name)));
const must = (ok, what) => {
  if (!ok) throw new Error(what + ": " + usd.error());
};

const usd = new native.TinyUSDZLoaderNative();
must(usd.loadAsLayerFromBinary(bytes("sequence.usda"), "sequence.usda"), "the stage is not read");
for (const name of [...usd.extractSublayerAssetPaths(), ...usd.extractReferencesAssetPaths()])
  usd.setAsset(name, bytes(name));
must(usd.composeSublayers(), "layers are not composed");
must(usd.composeReferences(), "references are not composed");
fs.writeSync(1, usd.layerToString());
must(usd.layerToRenderScene(), "there is nothing to draw");
fs.writeSync(2, `meshes ${usd.numMeshes()}\n`);
