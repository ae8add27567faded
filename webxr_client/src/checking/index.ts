/** The check of a headset: the page as it is, an observer of its events, and the report. */
import { h, render } from 'preact';
import type { Engine } from '../engine/engine';
import { state } from '../store/state';
import { watch } from '../store/watch';
import type { Headset } from '../xr/headset';
import { CheckPage } from './page';
import { openRecording } from './recording';
import { sendReport } from './report';
import { Findings, noteActions, Round } from './round';

export function installCheck(engine: Engine, headset: Headset): void {
  const findings = new Findings();
  noteActions();
  void openRecording();
  const place = document.createElement('div');
  document.body.append(place);
  render(h(CheckPage, { findings }), place);
  let round: Round | null = null;
  watch([state.xr], () => {
    const session = engine.viewer.renderer.xr.getSession();
    const { cockpit } = headset;
    if (state.xr.peek().session === 'running' && session && cockpit) {
      round ??= new Round(engine, cockpit, session, findings);
      return;
    }
    if (!round) return;
    round.stop();
    round = null;
    void sendReport(findings);
  });
}
