// The WebSocket to the server, reopened whenever it closes.

const PROTOCOL = "lariat.view.v1";
/** Delay before reconnecting in ms: at first, and at most. */
const AGAIN = [300, 3000];

/**
 * Keeps a connection open.
 *
 * @param hears handlers: `moment` for each moment, `state` for whether there is a connection, and
 * others by the type of the server's message
 */
export function connect(hears) {
  let socket = null;
  let again = AGAIN[0];
  let asked = 0;
  const waiting = new Map();

  function open() {
    const address = new URL("live", document.baseURI);
    address.protocol = address.protocol.replace("http", "ws");
    socket = new WebSocket(address, PROTOCOL);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      again = AGAIN[0];
      hears.state(true);
    };
    socket.onmessage = ({ data }) => {
      if (typeof data !== "string") return hears.moment(moment(data));
      const said = JSON.parse(data);
      if (said.type === "answer") return answer(said);
      return hears[said.type]?.(said);
    };
    socket.onclose = () => {
      for (const id of waiting.keys()) answer({ id, refused: "the server is gone" });
      hears.state(false);
      setTimeout(open, again);
      again = Math.min(2 * again, AGAIN[1]);
    };
  }

  function answer({ id, said, refused }) {
    const { resolve, reject } = waiting.get(id) ?? {};
    waiting.delete(id);
    if (refused == null) resolve?.(said);
    else reject?.(new Error(refused));
  }

  /** Sends a message, if there is a connection. */
  function say(what) {
    if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(what));
  }

  open();
  return {
    say,
    /** Sends a picture file to be traced. */
    drop(file) {
      if (socket.readyState === WebSocket.OPEN) socket.send(file);
    },
    /** Sends a request. Resolves to the answer, or rejects with the reason why it was refused. */
    ask(wish) {
      if (socket.readyState !== WebSocket.OPEN) return Promise.reject(new Error("the server is gone"));
      asked += 1;
      say({ type: "ask", id: asked, ...wish });
      return new Promise((resolve, reject) => waiting.set(asked, { resolve, reject }));
    },
  };
}

/**
 * Splits a moment's message: the lengths of its JSON and its JPEG, then the JSON, the JPEG, and a
 * PNG of the mask.
 */
function moment(data) {
  const head = new DataView(data);
  const ends = [8, head.getUint32(0, true), head.getUint32(4, true)];
  ends.forEach((length, i) => { ends[i] = length + (ends[i - 1] ?? 0); });
  const part = (from, to) => new Uint8Array(data, from, to - from);
  const picture = (from, to, type) => (to > from ? new Blob([part(from, to)], { type }) : null);
  return {
    said: JSON.parse(new TextDecoder().decode(part(ends[0], ends[1]))),
    jpeg: picture(ends[1], ends[2], "image/jpeg"),
    mask: picture(ends[2], data.byteLength, "image/png"),
    bytes: data.byteLength,
  };
}
