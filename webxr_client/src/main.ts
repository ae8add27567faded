/** Wiring only. */
import { Engine } from './engine/engine';
import { installHook } from './engine/hook';
import { mountPanels } from './panels/index';

const engine = new Engine(document.getElementById('view') as HTMLCanvasElement);
mountPanels();
installHook(engine);
engine.start();
