/** Wiring only. */
import { Engine } from './engine/engine';
import { installHook } from './engine/hook';
import { installOverlays } from './overlays/index';
import { mountPanels } from './panels/index';
import { installHeadset } from './xr/index';

const engine = new Engine(document.getElementById('view') as HTMLCanvasElement);
mountPanels();
installHeadset(engine, installOverlays(engine));
installHook(engine);
engine.start();
