// node played.mjs MODULE VARIANT VALUES OUT: writes the rows of a run as doubles.
import { readFileSync, writeFileSync } from "node:fs";

const [module, variant, values, out, numbers] = process.argv.slice(2);
const { instance } = await WebAssembly.instantiate(readFileSync(module), {});
const { memory, play_values, play_run, play_rows } = instance.exports;
for (const [part, list] of Object.entries(JSON.parse(values)))
  new Float64Array(memory.buffer, play_values(Number(part)), list.length).set(list);
if (!play_run(Number(variant))) throw new Error("the run failed");
writeFileSync(out, new Uint8Array(memory.buffer, play_rows(0), 8 * Number(numbers)));
