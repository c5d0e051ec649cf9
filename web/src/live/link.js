// The socket to the program: messages as view/message.h has them, and requests as view/request.h takes them.
const AGAIN = 1000; // milliseconds

/** A JSON object and the buffers that it names. */
export function parse(data) {
  const length = new DataView(data).getUint32(0, true);
  const message = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
  let offset = 4 + length;
  const buffers = {};
  for (const [name, size] of message.buffers ?? []) {
    offset = Math.ceil(offset / 4) * 4;
    buffers[name] = new Uint8Array(data, offset, size);
    offset += size;
  }
  return { ...message, buffers };
}

export class Link {
  /** `receive(message)` for each message, `onChange(isOpen)` when the program comes or goes. */
  constructor({ receive, onChange }) {
    this.receive = receive;
    this.onChange = onChange;
    this.wanted = true;
    this.open();
  }

  open() {
    const url = new URL(`live${location.search}`, location.href);
    url.protocol = 'ws:';
    this.socket = new WebSocket(url);
    this.socket.binaryType = 'arraybuffer';
    this.socket.onopen = () => this.onChange(true);
    this.socket.onmessage = ({ data }) => this.receive(parse(data));
    this.socket.onclose = () => {
      if (!this.wanted) return;
      this.onChange(false);
      setTimeout(() => this.open(), AGAIN);
    };
  }

  send(what, values = {}) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify({ do: what, ...values }));
  }

  /** For good. */
  close() {
    this.wanted = false;
    this.socket.close();
  }
}
