// The WebSocket to the server, opened again whenever it has gone.

const PROTOCOL = "lariat.view.v1";
/** How long after a connection has gone a new one is tried, in ms: at first, and at most. */
const AGAIN = [300, 3000];

/**
 * Keeps a connection open.
 *
 * @param hears what is called with each moment, with what the server says by its type, and with whether there is a connection (`state`)
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

  /** Says something, if there is a connection. */
  function say(what) {
    if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(what));
  }

  open();
  return {
    say,
    /** Has a picture file traced. */
    drop(file) {
      if (socket.readyState === WebSocket.OPEN) socket.send(file);
    },
    /** Asks for something; what is said to it, or why it was refused, as an error. */
    ask(wish) {
      if (socket.readyState !== WebSocket.OPEN) return Promise.reject(new Error("the server is gone"));
      asked += 1;
      say({ type: "ask", id: asked, ...wish });
      return new Promise((resolve, reject) => waiting.set(asked, { resolve, reject }));
    },
  };
}

/** A moment's message: the lengths of its JSON and its JPEG, these two, and a PNG of the mask. */
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
