/* What Python and the pages use of this module. */
export {render} from './widget.js';
export {openPage} from './page.js';
export {View} from './view.js';
