// node fmi3.mjs MODULE JOB: steps an FMU (FMI 3, co-simulation), prints its outputs.
import { readFileSync } from "node:fs";

const [module, job] = process.argv.slice(2);
const { token, input, outputs, start, inputs, h } = JSON.parse(job);
const { instance } = await WebAssembly.instantiate(readFileSync(module), {});
const fmi = instance.exports;
fmi._initialize();
let free = fmi.memory.grow(1) * 65536; // a page of our own
const place = (bytes) => {
  new Uint8Array(fmi.memory.buffer, free, bytes.length).set(bytes);
  const found = free;
  free += (bytes.length + 7) & ~7;
  return found;
};
const text = (s) => place(new TextEncoder().encode(`${s}\0`));
const room = (n) => place(new Uint8Array(n));
const wanted = (what, status) => {
  if (status !== 0) throw new Error(`${what}: ${status}`);
};
const one = fmi.fmi3InstantiateCoSimulation(
  text("one"), text(token), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0);
if (!one) throw new Error("not instantiated");
const reference = room(4), value = room(8), flags = room(32);
const set = (r, v) => {
  new Uint32Array(fmi.memory.buffer, reference, 1)[0] = r;
  new Float64Array(fmi.memory.buffer, value, 1)[0] = v;
  wanted("set", fmi.fmi3SetFloat64(one, reference, 1, value, 1));
};
const setBoolean = (r, v) => {
  new Uint32Array(fmi.memory.buffer, reference, 1)[0] = r;
  new Uint8Array(fmi.memory.buffer, value, 1)[0] = v;
  wanted("set", fmi.fmi3SetBoolean(one, reference, 1, value, 1));
};
const get = (r) => {
  new Uint32Array(fmi.memory.buffer, reference, 1)[0] = r;
  wanted("get", fmi.fmi3GetFloat64(one, reference, 1, value, 1));
  return new Float64Array(fmi.memory.buffer, value, 1)[0];
};
for (const [r, v] of start) setBoolean(r, v);
wanted("enter", fmi.fmi3EnterInitializationMode(one, 0, 0, 0, 0, 0));
wanted("exit", fmi.fmi3ExitInitializationMode(one));
const rows = inputs.map((u, k) => {
  set(input, u);
  const last = flags + 24;
  wanted("step", fmi.fmi3DoStep(one, k * h, h, 0, flags, flags + 8, flags + 16, last));
  return outputs.map(get);
});
console.log(JSON.stringify(rows));
