/* The page of a widget: shapes that turn together, modes that colour them, partners and rows on click. */
'use strict';

(() => {
  const data = JSON.parse(document.getElementById('data').textContent);
  const element = (id) => document.getElementById(id);

  function decoded(text, Type) {
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    return new Type(bytes.buffer);
  }

  function webgl() {
    const canvas = document.createElement('canvas');
    return canvas.getContext('webgl') || canvas.getContext('experimental-webgl');
  }

  /* One shape with its scene, canvas and marks. */
  class Pane {
    constructor(shape, camera) {
      this.positions = decoded(shape.positions, Float32Array);
      this.colors = new Float32Array(this.positions.length).fill(0.8);
      const geometry = new THREE.BufferGeometry();
      geometry.setIndex(new THREE.BufferAttribute(decoded(shape.index, Uint32Array), 1));
      this.positionAttribute = new THREE.BufferAttribute(this.positions, 3);
      geometry.addAttribute('position', this.positionAttribute);
      geometry.addAttribute('normal', new THREE.BufferAttribute(decoded(shape.normals, Float32Array), 3));
      this.colorAttribute = new THREE.BufferAttribute(this.colors, 3);
      geometry.addAttribute('color', this.colorAttribute);
      this.mesh = new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({
        vertexColors: THREE.VertexColors, side: THREE.DoubleSide,
        polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 2,
      }));
      this.scene = new THREE.Scene();
      this.scene.add(this.mesh, new THREE.AmbientLight(0xffffff, 0.52));
      for (const [x, y, z, intensity] of [[-4, 6, 8, 0.42], [6, 1, -4, 0.3], [-3, -4, -6, 0.18]]) {
        const lamp = new THREE.DirectionalLight(0xffffff, intensity);
        lamp.position.set(x, y, z);
        this.scene.add(lamp);
      }
      this.exported = [];  /* What belongs to the pick that the page was written with: a click takes it away. */
      for (const mark of shape.marks) this.put(ball(mark.place, mark.color), mark.lasts);
      for (const line of shape.lines) {
        const stroke = tube(decoded(line.points, Float32Array), line.color);
        if (stroke) this.put(stroke, line.lasts);
      }
      this.camera = camera;
      this.renderer = new THREE.WebGLRenderer({antialias: true, preserveDrawingBuffer: true});
      this.renderer.setPixelRatio(window.devicePixelRatio || 1);
      this.renderer.setSize(data.size[0], data.size[1]);
      this.renderer.setClearColor(0xf7f7f8, 1);
      const figure = document.createElement('figure');
      figure.innerHTML = `<figcaption>${shape.title}</figcaption><div class="view"></div>`;
      figure.lastChild.appendChild(this.renderer.domElement);
      element('panes').appendChild(figure);
      this.picked = ball([0, 0, 0], '#db1c29');
      this.picked.visible = false;
      this.marked = -1;
      this.numbers = shape.numbers ? decoded(shape.numbers, Int32Array) : null;
      this.scene.add(this.picked);
    }

    put(solid, lasts) {
      this.scene.add(solid);
      if (!lasts) this.exported.push(solid);
    }

    /* Whether there was something of the exported pick to take away. */
    forget() {
      const some = this.exported.length > 0;
      this.scene.remove(...this.exported);
      this.exported = [];
      return some;
    }

    paint(step) {
      if (step.lut) {
        const lut = decoded(step.lut, Uint8Array);
        const index = decoded(step.index, Uint8Array);
        for (let v = 0; v < index.length; v++) {
          for (let c = 0; c < 3; c++) this.colors[3 * v + c] = lut[3 * index[v] + c] / 255;
        }
      } else {
        const rgb = decoded(step.rgb, Uint8Array);
        for (let i = 0; i < rgb.length; i++) this.colors[i] = rgb[i] / 255;
      }
      this.colorAttribute.needsUpdate = true;
      this.sharpen(step.borders);
    }

    /* Pieces of triangles in which regions meet, over the mesh: between vertices WebGL mixes colours. */
    sharpen(borders) {
      if (this.overlay) {
        this.scene.remove(this.overlay);
        this.overlay.geometry.dispose();
        this.overlay = null;
      }
      if (!borders || !borders.positions) return;
      const geometry = new THREE.BufferGeometry();
      const positions = decoded(borders.positions, Float32Array);
      const rgb = decoded(borders.rgb, Uint8Array);
      const colors = Float32Array.from(positions, (_, i) => rgb[3 * Math.floor(i / 9) + i % 3] / 255);
      geometry.addAttribute('position', new THREE.BufferAttribute(positions, 3));
      geometry.addAttribute('normal', new THREE.BufferAttribute(decoded(borders.normals, Float32Array), 3));
      geometry.addAttribute('color', new THREE.BufferAttribute(colors, 3));
      this.overlay = new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({
        vertexColors: THREE.VertexColors, side: THREE.DoubleSide,
        polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
      }));
      this.scene.add(this.overlay);
    }

    /* The vertex nearest to what is under the mouse, -1 for none. */
    vertexAt(event) {
      const box = this.renderer.domElement.getBoundingClientRect();
      const mouse = new THREE.Vector2(
        2 * (event.clientX - box.left) / box.width - 1, 1 - 2 * (event.clientY - box.top) / box.height);
      const ray = new THREE.Raycaster();
      ray.setFromCamera(mouse, this.camera);
      const hit = ray.intersectObject(this.mesh)[0];
      if (!hit) return -1;
      const gap = (v) => hit.point.distanceTo(new THREE.Vector3().fromArray(this.positions, 3 * v));
      return [hit.face.a, hit.face.b, hit.face.c].reduce((a, b) => (gap(b) < gap(a) ? b : a));
    }

    /* Positions were changed: shading, clicks and the mark follow. */
    moved() {
      this.positionAttribute.needsUpdate = true;
      this.mesh.geometry.computeVertexNormals();
      this.mesh.geometry.computeBoundingSphere();
      this.mark(this.marked);
    }

    mark(vertex) {
      this.marked = vertex;
      this.picked.visible = vertex >= 0;
      if (vertex >= 0) this.picked.position.fromArray(this.positions, 3 * vertex);
    }

    draw() { this.renderer.render(this.scene, this.camera); }
  }

  function ball(place, color) {
    const solid = new THREE.Mesh(
      new THREE.SphereGeometry(data.radius, 20, 14), new THREE.MeshLambertMaterial({color}));
    solid.position.fromArray(place);
    return solid;
  }

  /* A curve as a solid; null where it has no length that a page could show. */
  function tube(points, color) {
    const path = new THREE.CurvePath();
    const at = (i) => new THREE.Vector3().fromArray(points, 3 * i);
    for (let i = 1; 3 * i < points.length; i++) {
      if (at(i).distanceTo(at(i - 1)) > 1e-6) path.add(new THREE.LineCurve3(at(i - 1), at(i)));
    }
    if (!path.curves.length) return null;
    const geometry = new THREE.TubeBufferGeometry(path, 2 * points.length / 3, data.radius / 3, 8);
    return new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({color}));
  }

  /* The matrix beside the shape: a row under the mouse becomes a function on the shape. */
  function matrixPane(matrix, paintRow) {
    const m = matrix.count;
    const figure = document.createElement('figure');
    figure.innerHTML = `<figcaption>${matrix.title}</figcaption><div class="matrix">${matrix.strip}<canvas></canvas></div>`;
    element('panes').insertBefore(figure, element('panes').firstChild);
    const canvas = figure.querySelector('canvas');
    canvas.width = canvas.height = m;
    canvas.style.width = canvas.style.height = `${data.size[1]}px`;
    const context = canvas.getContext('2d');
    const rgb = decoded(matrix.image, Uint8Array);
    const image = context.createImageData(m, m);
    for (let i = 0; i < m * m; i++) {
      for (let c = 0; c < 3; c++) image.data[4 * i + c] = rgb[3 * i + c];
      image.data[4 * i + 3] = 255;
    }
    context.putImageData(image, 0, 0);
    canvas.addEventListener('pointermove', (event) => {
      const box = canvas.getBoundingClientRect();
      const row = Math.min(Math.max(Math.floor(m * (event.clientY - box.top) / box.height), 0), m - 1);
      context.putImageData(image, 0, 0);
      context.fillStyle = '#ff2d55';
      context.fillRect(0, row, m, Math.max(1, m / 300));
      paintRow(row);
    });
  }

  element('info').hidden = !data.info;
  if (!webgl()) {
    drawsNothing('This browser shows no WebGL, so this is a still picture.');
    return;
  }

  const camera = new THREE.PerspectiveCamera(data.fov, data.size[0] / data.size[1], 0.01, 200);
  const panes = data.shapes.map((shape) => new Pane(shape, camera));
  const draw = () => panes.forEach((pane) => pane.draw());
  const orbit = new Orbit(camera, data.home, draw);
  orbit.target.fromArray(data.target);
  orbit.offset.setFromVector3(new THREE.Vector3().fromArray(data.camera).sub(orbit.target));

  function show() {
    const mode = data.modes[element('mode').value];
    const count = mode.steps.length;
    element('step').max = count;
    element('step-label').style.display = count > 1 ? '' : 'none';
    const k = Math.min(Number(element('step').value), count);
    element('step-value').textContent = k;
    const step = mode.steps[k - 1];
    panes.forEach((pane, i) => pane.paint(step.panes[i]));
    element('legend').innerHTML = step.legend;
    draw();
  }

  /* A new pick: marks, lines and lines of text about the one before go. */
  function picksAnew() {
    if (panes.filter((pane) => pane.forget()).length) element('info').hidden = true;
  }

  function clicked(number, event) {
    const vertex = panes[number].vertexAt(event);
    if (vertex < 0) return;
    picksAnew();
    const pair = data.partners ? decoded(data.partners[number], Int32Array)[vertex] : -1;
    panes.forEach((pane, i) => pane.mark(i === number ? vertex : pair));
    const names = data.shapes.map((shape) => shape.name);
    const own = panes[number].numbers ? panes[number].numbers[vertex] : vertex;
    element('picked').textContent = pair < 0
      ? `vertex ${own}` : `vertex ${vertex} of ${names[number]} ↔ vertex ${pair} of ${names[1 - number]}`;
    draw();
  }

  data.modes.forEach((mode, i) => element('mode').add(new Option(mode.name, i)));
  element('mode').value = data.start;
  element('step').value = data.step;
  element('mode').addEventListener('change', show);
  element('step').addEventListener('input', show);
  element('reset').addEventListener('click', () => orbit.reset());
  panes.forEach((pane, i) => orbit.connect(pane.renderer.domElement, (event) => clicked(i, event)));

  if (data.matrix) {
    const rows = decoded(data.matrix.rows, Uint8Array);
    const vertices = decoded(data.matrix.vertices, Int32Array);
    const lut = decoded(data.matrix.lut, Uint8Array);
    const n = panes[0].positions.length / 3;
    matrixPane(data.matrix, (row) => {
      picksAnew();
      for (let v = 0; v < n; v++) {
        for (let c = 0; c < 3; c++) panes[0].colors[3 * v + c] = lut[3 * rows[row * n + v] + c] / 255;
      }
      panes[0].colorAttribute.needsUpdate = true;
      panes[0].sharpen(null);
      panes[0].mark(vertices[row]);
      element('legend').innerHTML = data.matrix.legend;
      element('picked').textContent = `row ${row}: distances from vertex ${vertices[row]}`;
      draw();
    });
  }
  if (data.motion) {
    element('mode-label').hidden = data.modes.length < 2;
    const frames = data.motion.frames.map((text) => decoded(text, Float32Array));
    new Player(data.motion, (before, part) => {
      panes.forEach((pane, i) => {
        blend(frames[i], before, part, pane.positions);
        pane.moved();
      });
      draw();
    });
  }
  orbit.apply();
  show();
})();
