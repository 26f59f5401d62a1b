/* Bundles src/ and three.js into ../qgeo_widgets/static, which is part of the package, or into the folder that is
   named: `npm ci && npm run build`. */
import {build} from 'esbuild';
import {copyFile, readFile, writeFile} from 'node:fs/promises';
import {resolve} from 'node:path';
import {pathToFileURL} from 'node:url';

const into = process.argv[2]
  ? pathToFileURL(`${resolve(process.argv[2])}/`) : new URL('../qgeo_widgets/static/', import.meta.url);
const three = JSON.parse(await readFile(new URL('node_modules/three/package.json', import.meta.url)));

const common = {bundle: true, minify: true, target: 'es2022', charset: 'utf8', legalComments: 'none'};
await build({
  ...common,
  entryPoints: ['src/index.js'],
  outfile: new URL('renderer.js', into).pathname,
  format: 'iife',
  globalName: 'qgeoRenderer',
  banner: {js: `/* qgeo-renderer, with three.js ${three.version}, MIT licence: see three.LICENSE */`},
});
await build({
  ...common, entryPoints: ['src/matrix_widget.js'], outfile: new URL('matrix.js', into).pathname, format: 'esm',
});
await copyFile(new URL('src/renderer.css', import.meta.url), new URL('renderer.css', into));
await writeFile(new URL('three.LICENSE', into), await readFile(new URL('node_modules/three/LICENSE', import.meta.url)));
