/* Shapes side by side in one WebGL context, turned together by mouse, touch and keys. */
import {ColorManagement, LinearSRGBColorSpace, OrthographicCamera, PerspectiveCamera, WebGLRenderer} from 'three';
import {LookPanel} from './look.js';
import {LostNotice} from './lost.js';
import {Orbit} from './orbit.js';
import {Pane} from './pane.js';
import {withLegend} from './picture.js';
import {pictureTexture} from './texture.js';
import {ThemeWatch} from './theme.js';

/* Colours are those of the legend, as they are. */
ColorManagement.enabled = false;

const KEYS_HELP = 'Arrow keys turn, with shift they move; plus and minus come nearer and go away; home is the first view.';

/* `setup` is what Python sends of the shapes; the handlers `pick(pane, hit)`, `camera(state)`, `look(state)`
   and `again()`, where the browser has given up this canvas. */
export class View {
  constructor(root, setup, handlers = {}) {
    this.root = root;
    this.handlers = handlers;
    this.setup = setup;
    root.classList.add('qgeo-scene');
    root.style.setProperty('--qgeo-count', setup.panes.length);
    root.style.setProperty('--qgeo-width', `${setup.size[0]}px`);
    root.style.setProperty('--qgeo-aspect', `${setup.size[0]} / ${setup.size[1]}`);
    this.renderer = new WebGLRenderer({antialias: true, alpha: true, preserveDrawingBuffer: true});
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    this.renderer.setScissorTest(true);
    this.canvas = this.renderer.domElement;
    this.canvas.setAttribute('aria-hidden', 'true');
    this.canvas.addEventListener('webglcontextrestored', () => this.draw());
    this.lost = new LostNotice(this.canvas, () => handlers.again?.());
    const {aspect, near, far} = this.#clip();
    this.perspective = new PerspectiveCamera(setup.fov, aspect, near, far);
    this.orthographic = new OrthographicCamera(-1, 1, 1, -1, -far, far);
    this.camera = this.perspective;
    this.orbit = new Orbit(setup.home, setup.fov, () => this.#turned());
    this.panes = setup.panes.map((shape) => new Pane(shape, setup.radius));
    this.frames = setup.times?.length > 1 ? setup.times : null;
    this.grid = document.createElement('div');
    this.grid.className = 'qgeo-panes';
    this.windows = setup.panes.map((shape, number) => this.#window(shape, number));
    this.tip = document.createElement('div');
    this.tip.className = 'qgeo-tip';
    this.tip.hidden = true;
    this.panel = new LookPanel(this);
    root.append(this.lost.element, this.canvas, this.grid, this.panel.element, this.tip);
    this.look = this.panel.state;
    this.legend = '';  /* SVG, for pictures that are saved as such */
    this.brush = false;  /* whether a press on a shape paints, and does not turn it */
    this.observer = new ResizeObserver(() => this.#render());
    this.observer.observe(root);
    for (const each of this.windows) this.observer.observe(each);
    this.theme = new ThemeWatch(() => this.draw());
    this.#placeCamera();
    this.draw();
  }

  /* -- what is shown ------------------------------------------------------------------------------------------ */

  paint(number, paint) {
    this.panes[number].paint(paint);
    this.draw();
  }

  setMarks(number, marks) {
    this.panes[number].setMarks(marks);
    this.draw();
  }

  setLines(number, lines) {
    this.panes[number].setLines(lines);
    this.draw();
  }

  /* PNG or JPEG in bytes, none for no texture; drawn as soon as the browser has read it. */
  async setTexture(bytes) {
    const asked = this.asked = {};
    const texture = bytes?.byteLength ? await pictureTexture(bytes) : null;
    if (this.gone || asked !== this.asked) {  /* another one came meanwhile */
      texture?.dispose();
      return;
    }
    this.texture?.dispose();
    this.texture = texture;
    for (const pane of this.panes) pane.setTexture(texture);
    this.draw();
  }

  setCamera(state) {
    this.orbit.set(state);
    this.#placeCamera();
    this.draw();
  }

  reset() { this.orbit.reset(); }

  setLook(look) {
    this.look = {...this.look, ...look};
    this.panel.show(this.look);
    for (const pane of this.panes) pane.look(this.look);
    this.camera = this.look.orthographic ? this.orthographic : this.perspective;
    this.#placeCamera();
    this.draw();
  }

  /* The shapes at a time, where they move. */
  showTime(time) {
    if (!this.frames) return;
    let before = 0;
    while (before < this.frames.length - 2 && this.frames[before + 1] <= time) before++;
    const step = this.frames[before + 1] - this.frames[before];
    const part = step > 0 ? Math.min(Math.max((time - this.frames[before]) / step, 0), 1) : 0;
    for (const pane of this.panes) pane.blend(before, part);
    this.draw();
  }

  /* -- pictures ----------------------------------------------------------------------------------------------- */

  /* Draw with the next frame of the browser, once. */
  draw() {
    if (this.waiting || this.gone) return;
    this.waiting = requestAnimationFrame(() => {
      this.waiting = 0;
      this.#render();
    });
  }

  /* PNG of all shapes, so many times as large as on screen, as a Blob. */
  async picture(factor, transparent) {
    const ratio = this.renderer.getPixelRatio();
    this.renderer.setPixelRatio(factor);
    this.#render(transparent);
    const blob = await new Promise((done) => { this.canvas.toBlob(done, 'image/png'); });
    this.renderer.setPixelRatio(ratio);
    this.#render();
    return blob;
  }

  /* SVG of the same picture, with the titles of the shapes and the legend as text and lines, as a Blob. */
  async drawing(factor, transparent) {
    const png = await this.picture(factor, transparent);
    const box = this.root.getBoundingClientRect();
    const captions = this.windows.map((window) => {
      const place = window.getBoundingClientRect();
      const text = window.previousSibling.textContent;
      return {text, x: place.left - box.left + 2, y: place.top - box.top - 5};
    });
    const height = this.grid.getBoundingClientRect().bottom - box.top;
    return withLegend(png, [box.width, box.height], height, captions, this.legend, transparent);
  }

  dispose() {
    this.gone = true;
    cancelAnimationFrame(this.waiting);
    this.observer.disconnect();
    this.theme.dispose();
    for (const pane of this.panes) pane.dispose();
    this.texture?.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
    this.root.replaceChildren();
  }

  #render(transparent = false) {
    const box = this.root.getBoundingClientRect();
    if (!box.width || !box.height || this.gone) return;
    if (!transparent && this.ratio !== window.devicePixelRatio) {
      this.ratio = window.devicePixelRatio;
      this.renderer.setPixelRatio(this.ratio || 1);
    }
    if (box.width !== this.width || box.height !== this.height) {
      [this.width, this.height] = [box.width, box.height];
      this.renderer.setSize(box.width, box.height, false);
    }
    const background = transparent ? null : this.#background();
    this.renderer.setScissor(0, 0, box.width, box.height);
    this.renderer.setClearColor(0, 0);
    this.renderer.clear();
    this.panes.forEach((pane, number) => {
      const place = this.windows[number].getBoundingClientRect();
      const frame = [place.left - box.left, box.bottom - place.bottom, place.width, place.height];
      this.renderer.setViewport(...frame);
      this.renderer.setScissor(...frame);
      if (background) this.renderer.setClearColor(background, 1);
      this.renderer.render(pane.scene, this.camera);
    });
  }

  #background() {
    const chosen = this.look.background;
    return chosen === 'theme' ? getComputedStyle(this.root).getPropertyValue('--qgeo-ground').trim() : chosen;
  }

  /* -- inside ------------------------------------------------------------------------------------------------- */

  #clip() {
    const [width, height] = this.setup.size;
    const reach = this.setup.radius / 0.022;
    return {aspect: width / height, near: 0.02 * reach, far: 60 * reach};
  }

  #window(shape, number) {
    const figure = document.createElement('figure');
    const caption = document.createElement('figcaption');
    caption.innerHTML = shape.title;
    const window = document.createElement('div');
    window.className = 'qgeo-view';
    window.tabIndex = 0;
    window.setAttribute('role', 'application');
    window.setAttribute('aria-label', `${caption.textContent}. ${KEYS_HELP}`);
    figure.append(caption, window);
    this.grid.append(figure);
    this.orbit.connect(window, (event) => {
      const hit = this.#hit(number, event);
      if (hit) this.handlers.pick?.(number, hit);
    }, (event) => this.brush && this.#paints(number, event));
    window.addEventListener('pointermove', (event) => this.#hover(number, event));
    window.addEventListener('pointerleave', () => { this.tip.hidden = true; });
    return window;
  }

  #hit(number, event) {
    const box = this.windows[number].getBoundingClientRect();
    const x = 2 * (event.clientX - box.left) / box.width - 1;
    return this.panes[number].hit(x, 1 - 2 * (event.clientY - box.top) / box.height, this.camera);
  }

  /* Whether the brush is on the shape; what it touches is told. */
  #paints(number, event) {
    const hit = this.#hit(number, event);
    if (hit) this.handlers.paint?.(number, hit);
    return hit !== null;
  }

  /* Value, vertex and region under the mouse, looked up once a frame at most. */
  #hover(number, event) {
    if (event.buttons || event.pointerType === 'touch') {
      this.tip.hidden = true;
      return;
    }
    this.pointed = {number, event};
    this.asking ||= requestAnimationFrame(() => {
      this.asking = 0;
      if (this.gone) return;
      const {number: asked, event: last} = this.pointed;
      const hit = this.#hit(asked, last);
      this.tip.hidden = !hit;
      if (!hit) return;
      this.tip.textContent = this.panes[asked].said(hit.vertex);
      const box = this.root.getBoundingClientRect();
      const right = last.clientX - box.left > box.width / 2;
      this.tip.style.left = right ? '' : `${last.clientX - box.left + 14}px`;
      this.tip.style.right = right ? `${box.right - last.clientX + 14}px` : '';
      this.tip.style.top = `${last.clientY - box.top + 14}px`;
    });
  }

  #turned() {
    this.#placeCamera();
    this.draw();
    this.handlers.camera?.(this.orbit.state);
  }

  #placeCamera() {
    const height = this.orbit.slope * this.orbit.offset.radius;
    const aspect = this.perspective.aspect;
    Object.assign(this.orthographic, {left: -height * aspect, right: height * aspect, top: height, bottom: -height});
    for (const camera of [this.perspective, this.orthographic]) {
      camera.position.copy(this.orbit.position);
      camera.lookAt(this.orbit.target);
      camera.updateProjectionMatrix();
      camera.updateMatrixWorld();
    }
  }
}
