/* Turning, moving and coming nearer, the same for every view: one camera, one state. */
import {MathUtils, Matrix4, Spherical, Vector3} from 'three';

/* A press that moves by no more pixels is a click, as hands are not quite still. */
const STILL = 4;
const KEYS = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]};

export class Orbit {
  constructor(home, fov, changed) {
    this.home = new Vector3().fromArray(home);
    this.slope = Math.tan(MathUtils.degToRad(fov / 2));
    this.changed = changed;
    this.target = new Vector3();
    this.offset = new Spherical().setFromVector3(this.home);
  }

  get position() { return new Vector3().setFromSpherical(this.offset).add(this.target); }

  get state() { return {position: this.position.toArray(), target: this.target.toArray()}; }

  set({position, target}) {
    this.target.fromArray(target);
    this.offset.setFromVector3(new Vector3().fromArray(position).sub(this.target)).makeSafe();
  }

  reset() {
    this.set({position: this.home.toArray(), target: [0, 0, 0]});
    this.changed();
  }

  turn(dx, dy) {
    this.offset.theta -= 2 * Math.PI * dx;
    this.offset.phi -= 2 * Math.PI * dy;
    this.offset.makeSafe();
    this.changed();
  }

  nearer(factor) {
    const home = this.home.length();
    this.offset.radius = Math.min(Math.max(this.offset.radius * factor, 0.1 * home), 8 * home);
    this.changed();
  }

  move(dx, dy) {
    const height = 2 * this.slope * this.offset.radius;
    const axes = new Matrix4().lookAt(this.position, this.target, new Vector3(0, 1, 0)).elements;
    for (let i = 0; i < 3; i++) {
      this.target.setComponent(i, this.target.getComponent(i) + height * (dy * axes[4 + i] - dx * axes[i]));
    }
    this.changed();
  }

  /* Listen to an element; `clicked(event)` is called for a press that was not a drag. Where `paints(event)` is true of
     a press, it is called for every move, too, and nothing turns. */
  connect(element, clicked, paints = () => false) {
    const pointers = new Map();
    let travelled = 0;
    let painting = false;
    element.addEventListener('contextmenu', (event) => event.preventDefault());
    element.addEventListener('pointerdown', (event) => {
      element.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, event);
      travelled = pointers.size === 1 ? 0 : Infinity;  /* Of several fingers none clicks. */
      painting = pointers.size === 1 && event.button === 0 && paints(event);
    });
    element.addEventListener('pointermove', (event) => {
      const before = pointers.get(event.pointerId);
      if (!before) return;
      const dx = event.clientX - before.clientX;
      const dy = event.clientY - before.clientY;
      travelled += Math.hypot(dx, dy);
      if (painting) paints(event);
      else if (travelled > STILL || pointers.size > 1) this.#dragged(event, before, dx, dy, pointers, element);
      pointers.set(event.pointerId, event);
    });
    const released = (event) => {
      const own = pointers.delete(event.pointerId);
      if (own && event.type === 'pointerup' && event.button === 0 && !painting && travelled <= STILL) clicked(event);
    };
    element.addEventListener('pointerup', released);
    element.addEventListener('pointercancel', released);
    element.addEventListener('wheel', (event) => {
      event.preventDefault();
      this.nearer(Math.pow(0.95, -Math.sign(event.deltaY)));
    }, {passive: false});
    element.addEventListener('keydown', (event) => {
      if (this.#key(event)) {
        event.preventDefault();
        event.stopPropagation();  /* Notebooks have shortcuts of their own. */
      }
    });
  }

  #dragged(event, before, dx, dy, pointers, element) {
    const height = element.clientHeight;
    if (pointers.size === 2) {
      const other = [...pointers.values()].find((p) => p.pointerId !== event.pointerId);
      const gap = (p) => Math.hypot(p.clientX - other.clientX, p.clientY - other.clientY);
      this.nearer(gap(before) / Math.max(gap(event), 1));
      this.move(dx / height / 2, dy / height / 2);
    } else if (event.buttons & 2 || event.shiftKey) {
      this.move(dx / height, dy / height);
    } else {
      this.turn(dx / height, dy / height);
    }
  }

  /* Whether a key meant the view. */
  #key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return false;
    if (event.key in KEYS) {
      const [x, y] = KEYS[event.key];
      if (event.shiftKey) this.move(0.05 * x, 0.05 * y);
      else this.turn(x / 24, y / 24);
    } else if (event.key === '+' || event.key === '=') {
      this.nearer(0.9);
    } else if (event.key === '-') {
      this.nearer(1 / 0.9);
    } else if (event.key === 'Home') {
      this.reset();
    } else {
      return false;
    }
    return true;
  }
}
