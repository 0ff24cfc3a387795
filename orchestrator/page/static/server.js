// All that is asked of the server: JSON by HTTP, frames of numbers by one WebSocket.

export async function ask(view, query = {}, body = undefined) {
  const address = `/api/${view}?${new URLSearchParams(query)}`;
  const options = body === undefined ? {} : { method: "POST", body };
  let response;
  try {
    response = await fetch(address, options);
  } catch {
    throw new Error("feeddrive serve no longer answers; start it again");
  }
  const type = response.headers.get("content-type") ?? "";
  if (type.startsWith("image/svg")) return response.text();
  if (!type.startsWith("application/json")) throw new Error(await response.text());
  const found = await response.json();
  if (found.error) throw new Error(found.error);
  return found;
}

export const tell = (view, content) => ask(view, {}, JSON.stringify(content));

let socket = null;
let last = 0;
const waiting = new Map(); // id -> { done, failed, live }
const onChange = new Set();

export function changed(listener) {
  onChange.add(listener);
}

function opened() {
  if (socket && socket.readyState <= WebSocket.OPEN) return socket;
  socket = new WebSocket(`ws://${location.host}/socket`);
  socket.binaryType = "arraybuffer";
  socket.onmessage = ({ data }) => {
    const message = typeof data === "string" ? JSON.parse(data) : frame(data);
    if (message.changed) return onChange.forEach((listener) => listener());
    const asked = waiting.get(message.id);
    if (!asked) return;
    if (message.live) return asked.live?.(message);
    waiting.delete(message.id);
    if (message.error) asked.failed(new Error(message.error));
    else asked.done(message);
  };
  socket.onclose = () => {
    for (const { failed } of waiting.values()) {
      failed(new Error("feeddrive serve no longer answers; start it again"));
    }
    waiting.clear();
  };
  return socket;
}

// Send a message; `live` is told frames that come before the answer.
export function send(message, live = undefined) {
  const id = ++last;
  const promise = new Promise((done, failed) => waiting.set(id, { done, failed, live }));
  const text = JSON.stringify({ ...message, id });
  const to = opened();
  if (to.readyState === WebSocket.OPEN) to.send(text);
  else to.addEventListener("open", () => to.send(text), { once: true });
  return { id, promise };
}

export const watch = opened;

function frame(data) {
  const length = new DataView(data).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
  const numbers = new Float64Array(data, 4 + length);
  const part = ([first, count]) => numbers.subarray(first, first + count);
  for (const panel of head.panels) {
    for (const curve of panel.curves) {
      curve.x = part(curve.x);
      curve.y = part(curve.y);
    }
  }
  return head;
}
