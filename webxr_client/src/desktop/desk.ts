/** The desk at work: mouse, keys and camera over the engine, and the actions that are theirs. */
import type { ObjectBoxes } from '../boxes/index';
import { actions, bindActions } from '../store/actions';
import { canEdit, state } from '../store/state';
import type { Shown } from '../store/types';
import { watch } from '../store/watch';
import type { Engine } from '../engine/engine';
import { leaveBox } from '../boxes/changes';
import { pictureKeys } from '../cameras/painting';
import { leavePeople } from '../engine/find-people';
import { clip } from '../tools/clip';
import { AheadPreview } from '../tools/preview';
import { seenIn } from '../tools/seen';
import { addBookmark } from '../view/bookmarks';
import { Clipping } from '../view/clipping';
import { orthographic } from '../view/framing';
import { LabelNavigation } from '../view/going';
import { listenToKeys } from './keyboard';
import { DeskPointer } from './pointer';
import { DeskPresence } from './presence';

class Desk {
  private readonly pointer: DeskPointer;
  private readonly presence: DeskPresence;
  private readonly navigation: LabelNavigation;
  private readonly clipping: Clipping;
  /** Frame on screen when the mouse last looked. */
  private seen: Shown | null = null;

  constructor(
    private readonly engine: Engine,
    boxes: ObjectBoxes,
  ) {
    const { viewer, camera, strokes, objects, regions } = engine;
    const { frame, shift, changed, locked } = engine;
    const ahead = new AheadPreview({ locked, seen: seenIn(viewer.palette), shift, changed });
    this.pointer = new DeskPointer({
      viewer,
      camera,
      strokes,
      objects,
      regions,
      ahead,
      frame,
      boxes,
    });
    this.presence = new DeskPresence(engine.link);
    this.navigation = new LabelNavigation({
      viewer,
      camera,
      frame,
      seek: (index) => actions.time.seek(index),
    });
    this.clipping = new Clipping({ viewer, camera, frame });
    watch([state.frame, state.sequence, state.tool, canEdit], () => this.pointer.interrupt());
    const { tool, brush, activeLabel, palette, solo, view } = state;
    watch([tool, brush, activeLabel, palette, solo, view, clip], () => this.pointer.refresh());
    this.bind();
    listenToKeys(camera);
    viewer.ticks.add((now) => this.tick(now));
  }

  private tick(now: number): void {
    const { viewer, camera } = this.engine;
    if (viewer.renderer.xr.isPresenting) return;
    const shown = state.shown.peek();
    if (camera.update(now) || shown !== this.seen) {
      this.seen = shown;
      this.pointer.refresh();
      viewer.invalidate();
    }
    this.navigation.update();
    this.clipping.update();
    orthographic.value = viewer.camera.orthographic;
    this.pointer.update();
    this.presence.update(now, this.pointer.brushAt);
  }

  private bind(): void {
    const { camera, viewer, objects } = this.engine;
    const { pointer, navigation, clipping } = this;
    bindActions({
      view: {
        toggleOrthographic: () => {
          camera.toggleOrthographic();
          viewer.invalidate();
        },
        keepView: () => addBookmark(camera.view, state.frame.peek()),
        goToView: ({ frame, view }) => {
          if (frame !== state.frame.peek()) actions.time.seek(frame);
          camera.restore(view);
        },
        goToObject: (label = state.activeLabel.peek(), frame) => navigation.goTo(label, frame),
        clipTo: (slab) => clipping.set(slab),
      },
      tools: {
        aimAtMiddle: () => pointer.aimAtMiddle(),
        useInMiddle: () => pointer.useInMiddle(),
        cancelStroke: () =>
          pictureKeys.cancel() || pointer.cancel() || leavePeople() || objects.end() || leaveBox(),
        closeOutline: () => pictureKeys.close() || pointer.closeOutline(),
        takeBackCorner: () => pictureKeys.takeBack() || pointer.takeBackCorner(),
        snapBox: () => pointer.snapBox(),
      },
    });
  }
}

export function installDesk(engine: Engine, boxes: ObjectBoxes): void {
  new Desk(engine, boxes);
}
