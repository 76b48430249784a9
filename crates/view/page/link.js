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
      return hears[said.type]?.(said);
    };
    socket.onclose = () => {
      hears.state(false);
      setTimeout(open, again);
      again = Math.min(2 * again, AGAIN[1]);
    };
  }

  open();
  return {
    /** Says something, if there is a connection. */
    say(what) {
      if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(what));
    },
  };
}

/** A moment's message: the length of its JSON, the JSON, a JPEG. */
function moment(data) {
  const length = new DataView(data).getUint32(0, true);
  const said = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
  const jpeg = data.byteLength > 4 + length ? new Blob([new Uint8Array(data, 4 + length)], { type: "image/jpeg" }) : null;
  return { said, jpeg, bytes: data.byteLength };
}
