import { mountPanels } from './panels/index';

mountPanels();
