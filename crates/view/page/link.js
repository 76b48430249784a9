// The WebSocket to the server: moments and status come in, and after each moment the next is asked for.

const PROTOCOL = "lariat.view.v1";
/** How long after a connection has gone a new one is tried, in ms: at first, and at most. */
const AGAIN = [300, 3000];

/**
 * Keeps a connection open.
 *
 * @param {{moment: Function, status: Function, answer: Function, state: Function}} hears
 */
export function connect(hears) {
  let socket = null;
  let again = AGAIN[0];
  let wanted = null;

  function open() {
    const address = new URL("live", document.baseURI);
    address.protocol = address.protocol.replace("http", "ws");
    socket = new WebSocket(address, PROTOCOL);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      again = AGAIN[0];
      hears.state(true);
      if (wanted) say(wanted);
    };
    socket.onmessage = ({ data }) => {
      if (typeof data === "string") {
        const said = JSON.parse(data);
        (said.type === "status" ? hears.status : hears.answer)(said);
      } else {
        wanted = null;
        hears.moment(moment(data));
      }
    };
    socket.onclose = () => {
      hears.state(false);
      setTimeout(open, again);
      again = Math.min(2 * again, AGAIN[1]);
    };
  }

  function say(what) {
    if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(what));
  }

  open();
  return {
    say,
    /** Asks for the next moment, to be shown so many pixels wide. */
    next(width) {
      wanted = { type: "next", width: Math.round(width) };
      say(wanted);
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
