/* The matrix in a notebook: it follows the model that the kernel holds, and tells it of the mouse. */
import {MatrixCanvas} from './matrix.js';

function render({model, el}) {
  const canvas = new MatrixCanvas(model.get('count'), model.get('height'), {
    hover: (row, column) => model.send({kind: 'hover', row, column}),
    click: (row, column) => model.send({kind: 'click', row, column}),
  });
  const image = () => canvas.setImage(model.get('image'));
  const lines = () => canvas.show(...model.get('shown'));
  image();
  lines();
  model.on('change:image', image);
  model.on('change:shown', lines);
  el.append(canvas.canvas);
  return () => {
    model.off('change:image', image);
    model.off('change:shown', lines);
  };
}

export default {render};
