// The connection to the program: an endless answer that is read, and commands that are posted.

const KINDS = { outline: 1, update: 2, status: 3 };

/** Read messages until the program ends; each goes to the handler of its kind. */
export async function listen(handlers) {
  const answer = await fetch("stream", { cache: "no-store" });
  if (!answer.ok) throw new Error(await answer.text());
  const reader = answer.body.getReader();
  let rest = new Uint8Array(0);
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return;
    rest = handOut(joined(rest, value), handlers);
  }
}

function joined(first, second) {
  if (!first.length) return second;
  const both = new Uint8Array(first.length + second.length);
  both.set(first);
  both.set(second, first.length);
  return both;
}

/** Hand out all whole messages; of updates that came together only the last one is shown. */
function handOut(bytes, handlers) {
  let at = 0;
  let update = null;
  while (bytes.length - at >= 4) {
    const length = new DataView(bytes.buffer, bytes.byteOffset + at).getUint32(0, true);
    if (bytes.length - at < 4 + length) break;
    const kind = bytes[at + 4];
    const contents = bytes.slice(at + 5, at + 4 + length);
    at += 4 + length;
    if (kind === KINDS.update) {
      update = contents;
      handlers.count();
    } else if (kind === KINDS.outline) {
      handlers.outline(new TextDecoder().decode(contents));
    } else {
      handlers.status(JSON.parse(new TextDecoder().decode(contents)));
    }
  }
  if (update) handlers.update(update);
  return bytes.slice(at);
}

/** Posts commands in order, one at a time; a newer place of the hand replaces one that waits. */
export class Commands {
  constructor(onrefused) {
    this.viewer = "";
    this.waiting = [];
    this.busy = false;
    this.onrefused = onrefused;
  }

  send(command) {
    const last = this.waiting[this.waiting.length - 1];
    if (command.do === "drag" && last?.do === "drag") this.waiting.pop();
    this.waiting.push(command);
    if (!this.busy) this.post();
  }

  async post() {
    this.busy = true;
    while (this.waiting.length) {
      const body = JSON.stringify(this.waiting.shift());
      const headers = { "Content-Type": "application/json", "X-Viewer": this.viewer };
      try {
        const answer = await fetch("command", { method: "POST", headers, body });
        if (!answer.ok) this.onrefused(await answer.text());
      } catch {
        this.onrefused("the program does not answer");
      }
    }
    this.busy = false;
  }
}
