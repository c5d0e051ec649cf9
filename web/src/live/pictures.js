// What the camera sees, and what it saw before it was lost.
import { byId } from '../dom.js';

export class Pictures {
  constructor() {
    this.counts = { color: 0, depth: 0, good: 0 };
    this.ready = Promise.resolve(); // once the latest are to be seen
  }

  show({ kind, buffers }) {
    const figure = byId(kind);
    if (!figure) return;
    const before = this.ready;
    this.ready = createImageBitmap(new Blob([buffers.jpeg], { type: 'image/jpeg' })).then((bitmap) => {
      const canvas = figure.querySelector('canvas');
      if (canvas.width !== bitmap.width || canvas.height !== bitmap.height) [canvas.width, canvas.height] = [bitmap.width, bitmap.height];
      canvas.getContext('bitmaprenderer').transferFromImageBitmap(bitmap);
      this.counts[kind]++;
      return before;
    });
    if (kind !== 'good') figure.hidden = false;
    else this.hasGood = true;
    this.arrange();
  }

  /** Of a run that begins anew. */
  forget() {
    this.hasGood = false;
    this.arrange();
  }

  setLost(isLost) {
    this.isLost = isLost;
    this.arrange();
  }

  arrange() {
    byId('good').hidden = !(this.isLost && this.hasGood);
    byId('pictures').classList.toggle('lost', Boolean(this.isLost));
  }
}
