/* One shape in a scene of its own: mesh, colours, borders of regions, marks, lines, and motion. */
import {
  AmbientLight, BufferAttribute, BufferGeometry, DirectionalLight, DoubleSide, Mesh, MeshBasicMaterial,
  MeshLambertMaterial, Raycaster, Scene, SphereGeometry, Vector2, Vector3,
} from 'three';
import {Line2} from 'three/addons/lines/Line2.js';
import {LineGeometry} from 'three/addons/lines/LineGeometry.js';
import {LineMaterial} from 'three/addons/lines/LineMaterial.js';
import {indices, positions, typed} from './arrays.js';

/* Light from all around, so that no side that the camera turns to is dark. */
const LAMPS = [[-4, 6, 8, 0.42], [6, 1, -4, 0.3], [-3, -4, -6, 0.18]];
const AMBIENT = 0.52;
/* A line's points nearer to each other than this are one; a line of one point is not drawn. */
const NO_LENGTH = 1e-6;

export class Pane {
  constructor(shape, radius) {
    this.radius = radius;
    this.places = positions(shape.positions);
    this.count = this.places.length / 3;
    this.faces = indices(shape.index, this.count);
    this.numbers = shape.numbers ? typed(shape.numbers, Int32Array) : null;
    this.frames = shape.frames ? positions(shape.frames) : null;
    this.geometry = new BufferGeometry();
    this.geometry.setIndex(new BufferAttribute(this.faces, 1));
    this.geometry.setAttribute('position', new BufferAttribute(this.places, 3));
    this.geometry.setAttribute('color', new BufferAttribute(new Uint8Array(3 * this.count).fill(210), 3, true));
    this.geometry.computeVertexNormals();
    /* The mesh is pushed back a little, so that lines on it are not cut by it. */
    this.material = surfaceMaterial(2);
    this.laid = {checkered: {value: 0}, textured: {value: 0}, picture: {value: null}};
    this.placed = false;
    layOver(this.material, this.laid);
    this.mesh = new Mesh(this.geometry, this.material);
    this.edges = new Mesh(this.geometry, new MeshBasicMaterial({
      wireframe: true, color: 0x20242c, transparent: true, opacity: 0.35,
    }));
    this.edges.visible = false;
    this.scene = new Scene();
    this.lamps = [new AmbientLight(0xffffff, Math.PI * AMBIENT), ...LAMPS.map(([x, y, z, intensity]) => {
      const lamp = new DirectionalLight(0xffffff, Math.PI * intensity);
      lamp.position.set(x, y, z);
      return lamp;
    })];
    this.brightness = this.lamps.map((lamp) => lamp.intensity);
    this.scene.add(this.mesh, this.edges, ...this.lamps);
    this.borders = null;
    this.marks = new Map();
    this.lines = new Map();
    this.values = null;
    this.names = null;
  }

  /* -- colours ------------------------------------------------------------------------------------------------ */

  /* `rgb` (n, 3) in bytes; `values` (n,) and `names` are what is said of a vertex under the mouse. */
  paint({rgb, values, names, borders, cells, places, rounded}) {
    const color = this.geometry.getAttribute('color');
    color.array.set(typed(rgb, Uint8Array));
    color.needsUpdate = true;
    this.values = values ? typed(values, Float32Array) : null;
    this.names = names ?? null;
    this.rounded = rounded ?? false;  /* values in as many steps as there are colours */
    this.sharpen(borders ?? null);
    if (cells) this.#lay('cells', cells, 3);
    this.laid.checkered.value = cells ? 1 : 0;
    if (places) this.#lay('places', places, 2);
    this.placed = Boolean(places);
    this.#textured();
  }

  /* Coordinates of what lies over the colours, and where there are any: a triangle with a corner that has none, which
     is NaN, keeps its colours. */
  #lay(name, coordinates, size) {
    const all = typed(coordinates, Float32Array).slice();
    const known = new Uint8Array(this.count).fill(255);
    for (let i = 0; i < all.length; i++) {
      if (Number.isFinite(all[i])) continue;
      all[i] = 0;
      known[Math.floor(i / size)] = 0;
    }
    this.geometry.setAttribute(name, new BufferAttribute(all, size));
    this.geometry.setAttribute('known', new BufferAttribute(known, 1, true));
  }

  /* A texture to lie on the shape where it is painted with places on it. */
  setTexture(texture) {
    this.laid.picture.value = texture;
    this.#textured();
  }

  #textured() { this.laid.textured.value = this.placed && this.laid.picture.value ? 1 : 0; }

  /* Cover the triangles in which regions meet by pieces of one colour each. */
  sharpen(borders) {
    if (this.borders) {
      this.scene.remove(this.borders);
      this.borders.geometry.dispose();
      this.borders.material.dispose();
      this.borders = null;
    }
    if (!borders || !borders.positions.byteLength) return;
    const points = typed(borders.positions, Float32Array);
    const colors = typed(borders.rgb, Uint8Array);
    const corners = new Uint8Array(points.length);
    for (let i = 0; i < corners.length; i++) corners[i] = colors[3 * Math.floor(i / 9) + i % 3];
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(points, 3));
    geometry.setAttribute('normal', new BufferAttribute(typed(borders.normals, Float32Array), 3));
    geometry.setAttribute('color', new BufferAttribute(corners, 3, true));
    this.borders = new Mesh(geometry, surfaceMaterial(1));
    this.borders.material.flatShading = this.material.flatShading;
    this.scene.add(this.borders);
  }

  /* What is said of a vertex: its number on the user's own mesh, and its value or the name of its region. */
  said(vertex) {
    const number = this.numbers ? this.numbers[vertex] : vertex;
    if (!this.values) return `vertex ${number}`;
    const value = this.values[vertex];
    if (this.names) return `vertex ${number}: ${this.names[value] ?? 'none'}`;
    if (!Number.isFinite(value)) return `vertex ${number}: no value`;
    return `vertex ${number}: ${this.rounded ? `about ${Number(value.toPrecision(3))}` : Number(value.toPrecision(4))}`;
  }

  look({flat, edges, opacity, light}) {
    for (const material of [this.material, this.borders?.material]) {
      if (!material) continue;
      if (material.flatShading !== flat || material.transparent !== opacity < 1) material.needsUpdate = true;
      material.flatShading = flat;
      material.transparent = opacity < 1;
      material.opacity = opacity;
      material.depthWrite = opacity > 0.6;
    }
    this.edges.visible = edges;
    this.lamps.forEach((lamp, i) => { lamp.intensity = light * this.brightness[i]; });
  }

  /* -- marks and lines ---------------------------------------------------------------------------------------- */

  /* Balls at places or, while the shape moves, at vertices. */
  setMarks(marks) {
    for (const mark of this.marks.values()) this.#drop(mark.ball);
    this.marks.clear();
    for (const {slot, place, color, vertex} of marks) {
      const ball = new Mesh(new SphereGeometry(this.radius, 20, 14), new MeshLambertMaterial({color}));
      ball.position.fromArray(place ?? this.at(vertex));
      this.scene.add(ball);
      this.marks.set(slot, {ball, vertex: vertex ?? -1});
    }
  }

  setLines(lines) {
    for (const line of this.lines.values()) this.#drop(line);
    this.lines.clear();
    for (const {slot, points, color, width} of lines) {
      const curve = spread(typed(points, Float32Array));
      if (curve.length < 6) continue;
      const line = new Line2(new LineGeometry(), new LineMaterial({color, linewidth: width}));
      line.geometry.setPositions(curve);
      this.scene.add(line);
      this.lines.set(slot, line);
    }
  }

  at(vertex) { return [...this.places.subarray(3 * vertex, 3 * vertex + 3)]; }

  /* -- motion ------------------------------------------------------------------------------------------------- */

  /* The shape part of the way from one frame to the next; what is at its vertices goes along. */
  blend(before, part) {
    const size = this.places.length;
    const a = before * size;
    const b = part > 0 ? a + size : a;
    for (let i = 0; i < size; i++) this.places[i] = (1 - part) * this.frames[a + i] + part * this.frames[b + i];
    this.geometry.getAttribute('position').needsUpdate = true;
    this.geometry.computeVertexNormals();
    this.geometry.computeBoundingSphere();
    for (const {ball, vertex} of this.marks.values()) {
      if (vertex >= 0) ball.position.fromArray(this.places, 3 * vertex);
    }
  }

  /* -- under the mouse ---------------------------------------------------------------------------------------- */

  /* Where a ray through the picture, from -1 to 1 both ways, meets the shape: point, corners, nearest of these. */
  hit(x, y, camera) {
    const ray = new Raycaster();
    ray.setFromCamera(new Vector2(x, y), camera);
    const first = ray.intersectObject(this.mesh)[0];
    if (!first) return null;
    const corners = [first.face.a, first.face.b, first.face.c];
    const gap = (v) => first.point.distanceTo(new Vector3().fromArray(this.places, 3 * v));
    const vertex = corners.reduce((a, b) => (gap(b) < gap(a) ? b : a));
    return {point: first.point.toArray(), corners, vertex};
  }

  dispose() {
    this.setMarks([]);
    this.setLines([]);
    this.sharpen(null);
    this.geometry.dispose();
    this.material.dispose();
    this.edges.material.dispose();
  }

  #drop(solid) {
    this.scene.remove(solid);
    solid.geometry.dispose();
    solid.material.dispose();
  }
}

function surfaceMaterial(offset) {
  return new MeshLambertMaterial({
    vertexColors: true, side: DoubleSide,
    polygonOffset: true, polygonOffsetFactor: offset, polygonOffsetUnits: offset,
  });
}

/* A texture instead of the colours of a material, where the geometry has `places` on it, and a checkerboard over them,
   where it has coordinates `cells`; each where its uniform is 1, and all corners of the triangle are `known`. */
function layOver(material, uniforms) {
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, uniforms);
    shader.vertexShader = shader.vertexShader.replace('void main() {', `attribute vec3 cells;
      attribute vec2 places;
      attribute float known;
      varying vec3 vCells;
      varying vec2 vPlaces;
      varying float vKnown;
      void main() {
        vCells = cells;
        vPlaces = places;
        vKnown = known;`);
    shader.fragmentShader = shader.fragmentShader
      .replace('void main() {', `uniform float checkered;
        uniform float textured;
        uniform sampler2D picture;
        varying vec3 vCells;
        varying vec2 vPlaces;
        varying float vKnown;
        void main() {`)
      .replace('#include <color_fragment>', `#include <color_fragment>
        vec3 print = texture2D(picture, vPlaces).rgb;
        float laid = step(0.999, vKnown);
        if (textured > 0.5) diffuseColor.rgb = mix(diffuseColor.rgb, print, laid);
        if (checkered > 0.5) {
          vec3 wave = sin(3.14159265 * vCells);
          float side = wave.x * wave.y * wave.z;
          float soft = fwidth(side);
          diffuseColor.rgb *= 1.0 - 0.45 * laid * smoothstep(soft, -soft, side);
        }`);
  };
}

/* Points of a curve without those that repeat the one before. */
function spread(points) {
  const kept = [];
  for (let i = 0; i < points.length; i += 3) {
    const last = kept.length - 3;
    if (last < 0 || Math.hypot(...[0, 1, 2].map((c) => points[i + c] - kept[last + c])) > NO_LENGTH) {
      kept.push(points[i], points[i + 1], points[i + 2]);
    }
  }
  return kept;
}
