// What zarrita reads: node zarrita.mjs FOLDER_OF_NODE_MODULES PATH ZARR...; the shape and type of each as a line of JSON, its
// samples to ZARR.bin.
import fs from "node:fs";
import path from "node:path";
import { pathToFileURL } from "node:url";

const [modules, array, ...roots] = process.argv.slice(2);
const folder = path.join(modules, "node_modules", "zarrita");
const { exports } = JSON.parse(fs.readFileSync(path.join(folder, "package.json"), "utf8"));
const zarr = await import(pathToFileURL(path.join(folder, exports["."].import)).href);

const storeOf = (root) => ({
  async get(key) {
    try {
      return new Uint8Array(fs.readFileSync(path.join(root, key)));
    } catch (error) {
      if (error.code === "ENOENT" || error.code === "EISDIR") return undefined;
      throw error;
    }
  },
  async getRange(key, range) {
    const data = await this.get(key);
    if (data === undefined) return undefined;
    if (range.suffixLength !== undefined) return data.slice(data.length - range.suffixLength);
    return data.slice(range.offset, range.offset + range.length);
  },
});

for (const root of roots) {
  const opened = await zarr.open(zarr.root(storeOf(root)).resolve(array), { kind: "array" });
  const samples = await zarr.get(opened);
  fs.writeFileSync(root + ".bin", new Uint8Array(samples.data.buffer, samples.data.byteOffset, samples.data.byteLength));
  console.log(JSON.stringify({ shape: samples.shape, type: opened.dtype }));
}
