/* Turning, moving and coming nearer, the same for every canvas that it listens to: one camera, one state. */
'use strict';

class Orbit {
  constructor(camera, home, changed) {
    this.camera = camera;
    this.home = new THREE.Vector3().fromArray(home);
    this.changed = changed;
    this.reset();
  }

  reset() {
    this.target = new THREE.Vector3();
    this.offset = new THREE.Spherical().setFromVector3(this.home);
    this.apply();
  }

  apply() {
    this.offset.makeSafe();
    this.camera.position.copy(new THREE.Vector3().setFromSpherical(this.offset)).add(this.target);
    this.camera.lookAt(this.target);
    this.camera.updateMatrixWorld();
    this.changed();
  }

  /* Listen to a canvas; `clicked(event)` is called for a press that was not a drag. */
  connect(canvas, clicked) {
    const pointers = new Map();
    let travelled = 0;
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
    canvas.addEventListener('pointerdown', (event) => {
      canvas.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, event);
      if (pointers.size === 1) travelled = 0;
    });
    canvas.addEventListener('pointermove', (event) => {
      const before = pointers.get(event.pointerId);
      if (!before) return;
      const dx = event.clientX - before.clientX;
      const dy = event.clientY - before.clientY;
      travelled += Math.abs(dx) + Math.abs(dy);
      if (pointers.size === 2) {
        const other = [...pointers.values()].find((p) => p.pointerId !== event.pointerId);
        const gap = (p) => Math.hypot(p.clientX - other.clientX, p.clientY - other.clientY);
        this.nearer(gap(before) / Math.max(gap(event), 1));
      } else if (event.buttons & 2 || event.shiftKey) {
        this.move(dx / canvas.clientHeight, dy / canvas.clientHeight);
      } else {
        this.turn(dx / canvas.clientHeight, dy / canvas.clientHeight);
      }
      pointers.set(event.pointerId, event);
    });
    const released = (event) => {
      const own = pointers.delete(event.pointerId);
      if (own && event.type === 'pointerup' && event.button === 0 && travelled < 4) clicked(event);
    };
    canvas.addEventListener('pointerup', released);
    canvas.addEventListener('pointercancel', released);
    canvas.addEventListener('wheel', (event) => {
      event.preventDefault();
      this.nearer(Math.pow(0.95, -Math.sign(event.deltaY)));
    }, {passive: false});
  }

  turn(dx, dy) {
    this.offset.theta -= 2 * Math.PI * dx;
    this.offset.phi -= 2 * Math.PI * dy;
    this.apply();
  }

  nearer(factor) {
    const home = this.home.length();
    this.offset.radius = Math.min(Math.max(this.offset.radius * factor, 0.1 * home), 8 * home);
    this.apply();
  }

  move(dx, dy) {
    const height = 2 * Math.tan(THREE.Math.degToRad(this.camera.fov / 2)) * this.offset.radius;
    const axes = new THREE.Matrix4().extractRotation(this.camera.matrixWorld).elements;
    for (let i = 0; i < 3; i++) {
      this.target.setComponent(i, this.target.getComponent(i) + height * (dy * axes[4 + i] - dx * axes[i]));
    }
    this.apply();
  }
}
