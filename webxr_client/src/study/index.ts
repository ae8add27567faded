/** The page of a participant: cards at the desk, a panel in the headset, and the session. */
import { computed } from '@preact/signals';
import { h, render } from 'preact';
import type { Engine } from '../engine/engine';
import { state } from '../store/state';
import { watch } from '../store/watch';
import type { Headset } from '../xr/headset';
import { StudyBar, StudyCards } from './cards';
import { StudyPanel } from './panel';
import { startSession } from './session';

export function installStudy(engine: Engine, headset: Headset): void {
  startSession(engine, headset, StudyBar);
  const place = document.createElement('div');
  document.body.append(place);
  render(h(StudyCards, {}), place);
  const session = computed(() => state.xr.value.session);
  watch([session], () => {
    // The panel goes with its cockpit.
    if (session.peek() === 'running') headset.cockpit?.hang(new StudyPanel());
  });
}
