/* A page that cannot draw says so, with the error and the still picture: nobody has to guess at an empty page. */
'use strict';

const drawsNothing = (sentence) => {
  document.getElementById('why').textContent = sentence;
  document.getElementById('no-drawing').hidden = false;
  document.getElementById('controls').hidden = true;
  document.getElementById('panes').hidden = true;
  document.getElementById('player').hidden = true;
};

window.addEventListener('error', (event) => {
  drawsNothing(`This page could not draw the shapes, so this is a still picture. The error was: ${event.message}`);
});
