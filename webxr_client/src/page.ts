/** Wiring only. */
import { ObjectBoxes } from './boxes/index';
import { BoxesPanel } from './boxes/panel';
import { isCheck, studyCode } from './common/checking';
import { installCameras } from './cameras/strip';
import { installDesk } from './desktop/desk';
import { CommandPalette } from './desktop/command-palette';
import { Help } from './desktop/help';
import { Engine } from './engine/engine';
import { PeoplePreview } from './engine/find-people';
import { installHook } from './engine/hook';
import { followOwnKeys } from './engine/people/own-keys';
import { ExampleBar, ExampleButton } from './example/bar';
import { ExamplePanel } from './example/panel';
import { Predicting } from './example/predicting';
import type { Early } from './net/early';
import { installOverlays, type Overlays } from './overlays/index';
import { mountPanels } from './panels/index';
import { ProjectSettings } from './team/settings-dialog';
import { bindActions } from './store/actions';
import { notify, state } from './store/state';
import { installTheme } from './store/theme';
import { follow } from './store/watch';
import { Compared } from './work/compared';
import { Flight } from './work/flight';
import { followWork } from './work/following';
import { WorkButton, WorkPanel } from './work/panel';
import { HandInQuestion } from './work/question';
import { begin } from './work/queue';

/** Longest wait for the first picture before the rest of the page is loaded. */
const LONGEST_MS = 1500;

export function startPage(early: Early): void {
  installTheme();
  const engine = new Engine(document.getElementById('view') as HTMLCanvasElement, early);
  if (early.refused)
    state.connection.value = { state: 'refused', detail: '', retryAt: null, unsent: [] };
  void early.opening.then(() => {
    if (early.missing === null) return;
    notify(
      'error',
      `There is no recording “${early.missing}”`,
      'It may have been deleted, or the link is wrong.',
    );
  });
  const overlays = installOverlays(engine);
  installCameras(engine);
  installHook(engine);
  engine.start();
  const boxes = new ObjectBoxes(engine);
  installDesk(engine, boxes);
  // The points come first: tools and headset are only useful after the first picture.
  void pictured(early).then(async () => {
    mountPanels({
      buttons: [ExampleButton, WorkButton],
      bars: [ExampleBar],
      dialogs: [Help, CommandPalette, ProjectSettings, HandInQuestion],
      asides: [
        ['boxes', 'Boxes', BoxesPanel],
        ['work', 'Work', WorkPanel],
        ['example', 'By example', ExamplePanel],
      ],
    });
    followOwnKeys();
    followWork();
    const openStudies = async (): Promise<void> =>
      (await import('./study/manage')).openStudies(engine);
    bindActions({ recordings: { nextTask: begin }, page: { openStudies } });
    new Predicting(engine);
    new PeoplePreview(engine);
    new Compared(engine);
    new Flight(engine);
    await installLast(engine, overlays);
  });
}

/** Install the headset, and with it a study, the check of headsets or the first minute. */
async function installLast(engine: Engine, overlays: Overlays): Promise<void> {
  const { installHeadset, leadFirstMinute } = await import('./xr/index');
  const headset = installHeadset(engine, overlays);
  if (studyCode() !== null) {
    const { installStudy } = await import('./study/index');
    installStudy(engine, headset);
  } else if (isCheck()) {
    const { installCheck } = await import('./checking/index');
    installCheck(engine, headset);
  } else leadFirstMinute(engine, headset);
}

/** Resolves once points have been drawn, when none are to be waited for, or after a while. */
function pictured({ opening }: Early): Promise<void> {
  return new Promise((resolve) => {
    const timer = setTimeout(finish, LONGEST_MS);
    const stop = follow(() => {
      // Drawn with the next picture, and over when the one after that begins.
      if (state.shown.value.total > 0) requestAnimationFrame(() => requestAnimationFrame(finish));
    });
    void opening.then((id) => id ?? finish());
    function finish(): void {
      clearTimeout(timer);
      stop();
      resolve();
    }
  });
}
