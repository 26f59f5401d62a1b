/* What stands over shapes while the browser has given up drawing them: it draws for so many canvases and no more, and
   for none while its graphics start anew. */

export class LostNotice {
  /* `again()` draws everything anew, in another canvas. */
  constructor(canvas, again) {
    this.element = document.createElement('div');
    this.element.className = 'qgeo-lost';
    this.element.setAttribute('role', 'alert');
    this.element.hidden = true;
    canvas.addEventListener('webglcontextlost', () => this.#show(again));
    canvas.addEventListener('webglcontextrestored', () => { this.element.hidden = true; });
  }

  #show(again) {
    const sentence = document.createElement('span');
    sentence.textContent = 'The browser has stopped drawing these shapes: too many are open, or its graphics failed. ';
    const button = document.createElement('button');
    button.type = 'button';
    button.textContent = 'draw anew';
    button.addEventListener('click', again);
    this.element.replaceChildren(sentence, button);
    this.element.hidden = false;
  }
}
