/* A square matrix as a picture whose rows answer to mouse and keys. */
import {typed} from './arrays.js';

const LINE = '#ff2d55';

export class MatrixCanvas {
  /* `hover(row, column)` and `click(row, column)` are called for entries under the mouse; keys choose rows, too. */
  constructor(count, height, {hover, click}) {
    this.count = count;
    this.canvas = document.createElement('canvas');
    this.canvas.className = 'qgeo-matrix';
    this.canvas.width = this.canvas.height = count;
    this.canvas.style.cssText = `width: min(${height}px, 100%); aspect-ratio: 1`;
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute('role', 'application');
    this.canvas.setAttribute('aria-label', 'Matrix of distances. Arrow keys choose a row, which colours the shape.');
    this.context = this.canvas.getContext('2d');
    this.row = this.column = -1;
    this.over = '';
    this.canvas.addEventListener('pointermove', (event) => {
      const entry = this.#entry(event);
      if (this.over === String(entry)) return;
      this.over = String(entry);
      hover(...entry);
    });
    this.canvas.addEventListener('click', (event) => click?.(...this.#entry(event)));
    this.canvas.addEventListener('keydown', (event) => {
      const step = {ArrowUp: -1, ArrowDown: 1, PageUp: -count / 20, PageDown: count / 20}[event.key];
      if (!step) return;
      event.preventDefault();
      event.stopPropagation();  /* Notebooks have shortcuts of their own. */
      hover(Math.min(Math.max(this.row + Math.round(step), 0), count - 1), 0);
    });
  }

  /* Picture (count, count, 3) in bytes. */
  setImage(bytes) {
    const rgb = typed(bytes, Uint8Array);
    this.image = this.context.createImageData(this.count, this.count);
    const {data} = this.image;
    for (let i = 0, k = 0; i < rgb.length; i += 3, k += 4) {
      data[k] = rgb[i];
      data[k + 1] = rgb[i + 1];
      data[k + 2] = rgb[i + 2];
      data[k + 3] = 255;
    }
    this.#draw();
  }

  /* Lines along a row and a column, -1 for none. */
  show(row, column) {
    [this.row, this.column] = [row, column];
    this.#draw();
  }

  #draw() {
    const thick = Math.max(1, this.count / 300);
    this.context.putImageData(this.image, 0, 0);
    this.context.fillStyle = LINE;
    if (this.row >= 0) this.context.fillRect(0, this.row, this.count, thick);
    if (this.column >= 0) this.context.fillRect(this.column, 0, thick, this.count);
  }

  #entry(event) {
    const box = this.canvas.getBoundingClientRect();
    const at = (part) => Math.min(Math.max(Math.floor(this.count * part), 0), this.count - 1);
    return [at((event.clientY - box.top) / box.height), at((event.clientX - box.left) / box.width)];
  }
}
