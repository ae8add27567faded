import { mountPanels } from './panels/index';

mountPanels(document.getElementById('panels')!);
