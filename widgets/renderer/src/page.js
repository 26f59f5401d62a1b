/* The page of a widget, which opens offline: shapes that turn together, modes that colour them, partners and rows. */
import {typed} from './arrays.js';
import {MatrixCanvas} from './matrix.js';
import {Player} from './player.js';
import {View} from './view.js';

const element = (id) => document.getElementById(id);
const PICKED = '#db1c29';

/* Show what the page holds: a description, and one block of compressed bytes that its arrays lie in. */
export async function openPage() {
  const data = JSON.parse(element('data').textContent);
  const block = await inflated(element('arrays').textContent.trim());
  new Page(resolved(data, block)).start();
}

async function inflated(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new Response(stream).arrayBuffer();
}

/* The same description with bytes where it names a part of the block. */
function resolved(item, block) {
  if (Array.isArray(item)) return item.map((each) => resolved(each, block));
  if (item === null || typeof item !== 'object') return item;
  if ('bytes_at' in item) return new Uint8Array(block, item.bytes_at, item.length);
  return Object.fromEntries(Object.entries(item).map(([key, each]) => [key, resolved(each, block)]));
}

class Page {
  constructor(data) {
    this.data = data;
    this.shapes = data.setup.panes;
    this.names = this.shapes.map((shape) => shape.name);
    this.picked = this.shapes.map(() => -1);
    this.exported = this.shapes.some((shape) => [...shape.marks, ...shape.lines].some((each) => !each.lasts));
    this.bare = !this.exported;
  }

  start() {
    const {data} = this;
    element('info').hidden = !data.info;
    this.view = new View(element('panes'), data.setup, {
      pick: (pane, hit) => this.clicked(pane, hit.vertex),
      again: () => location.reload(),
    });
    if (data.camera) this.view.setCamera(data.camera);
    this.view.setLook(data.look);
    if (data.texture) this.view.setTexture(data.texture);
    this.putMarks();
    data.modes.forEach((mode, i) => element('mode').add(new Option(mode.name, i)));
    element('mode').value = data.start;
    element('step').value = data.step;
    element('mode').addEventListener('change', () => this.show());
    element('step').addEventListener('input', () => this.show());
    element('reset').addEventListener('click', () => this.view.reset());
    if (data.matrix) this.addMatrix(data.matrix);
    this.show();
    if (data.motion) {
      element('mode-label').hidden = data.modes.length < 2;
      new Player(data.motion, (time) => this.view.showTime(time));
    }
  }

  show() {
    const mode = this.data.modes[element('mode').value];
    const count = mode.steps.length;
    element('step').max = count;
    element('step-label').style.display = count > 1 ? '' : 'none';
    const k = Math.min(Number(element('step').value), count);
    element('step-value').textContent = k;
    const step = mode.steps[k - 1];
    step.panes.forEach((pane, i) => this.view.paint(i, painted(pane, step)));
    element('legend').innerHTML = step.legend;
    this.view.legend = step.drawing;
  }

  /* What was marked when the page was written, until the first click: then only what lasts, and the new pick. */
  putMarks() {
    this.shapes.forEach((shape, i) => {
      const left = (each) => each.lasts || !this.bare;
      const own = this.picked[i] < 0 ? [] : [{slot: 'here', vertex: this.picked[i], color: PICKED}];
      this.view.setMarks(i, [...shape.marks.filter(left), ...own]);
      this.view.setLines(i, shape.lines.filter(left));
    });
  }

  pick(vertices) {
    this.picked = vertices;
    if (this.exported) element('info').hidden = true;
    this.bare = true;
    this.putMarks();
  }

  clicked(number, vertex) {
    const partners = this.data.partners?.[number];
    const [pair, drawn] = partners ? [partners.vertices, partners.drawn].map((all) => typed(all, Int32Array)[vertex]) : [-1, -1];
    this.pick(this.shapes.map((_, i) => (i === number ? vertex : drawn)));
    const {numbers} = this.view.panes[number];
    const said = `vertex ${numbers ? numbers[vertex] : vertex}`;
    element('picked').textContent = pair < 0
      ? `${said}${partners ? ' has no partner' : ''}`
      : `${said} of ${this.names[number]} ↔ vertex ${pair} of ${this.names[1 - number]}`;
  }

  addMatrix(matrix) {
    const rows = typed(matrix.rows, Uint8Array);
    const vertices = typed(matrix.vertices, Int32Array);
    const drawn = typed(matrix.drawn, Int32Array);
    const n = this.view.panes[0].count;
    const canvas = new MatrixCanvas(matrix.count, this.data.setup.size[1], {hover: (row) => {
      canvas.show(row, -1);
      this.view.paint(0, painted({index: rows.subarray(row * n, (row + 1) * n), lut: matrix.lut}, matrix));
      this.pick([drawn[row]]);
      element('legend').innerHTML = matrix.legend;
      this.view.legend = matrix.drawing;
      element('picked').textContent = `row ${row}: distances from vertex ${vertices[row]}`;
    }});
    canvas.setImage(matrix.image);
    const figure = document.createElement('figure');
    figure.style.cssText = `flex: 1 1 300px; max-width: ${this.data.setup.size[1] + 24}px`;
    figure.innerHTML = `<figcaption>${matrix.title}</figcaption><div class="matrix">${matrix.strip}</div>`;
    figure.lastChild.append(canvas.canvas);
    element('shapes').prepend(figure);
  }
}

/* Colours, and what is said of a vertex, from an index into a table of colours or from the colours themselves. */
function painted(pane, {scale, names}) {
  if (!pane.lut) return {rgb: pane.rgb, values: pane.regions && Float32Array.from(pane.regions), names, borders: pane.borders, cells: pane.cells, places: pane.places};
  const lut = typed(pane.lut, Uint8Array);
  const index = typed(pane.index, Uint8Array);
  const last = lut.length / 3 - 1;  /* for what is not finite */
  const rgb = new Uint8Array(3 * index.length);
  const values = new Float32Array(index.length);
  for (let v = 0; v < index.length; v++) {
    for (let c = 0; c < 3; c++) rgb[3 * v + c] = lut[3 * index[v] + c];
    values[v] = index[v] === last ? NaN : scale[0] + (scale[1] - scale[0]) * index[v] / (last - 1);
  }
  return {rgb, values, rounded: true};
}
