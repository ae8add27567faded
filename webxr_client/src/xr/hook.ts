/** `window.__pointbrushHeadset`: state of the headset for tests. */
import type { Vector3 } from 'three';
import type { Engine } from '../engine/engine';
import { halted, unsure } from '../engine/review';
import type { Overlays } from '../overlays/index';
import { peek } from '../store/watch';
import { state } from '../store/state';
import type { Headset } from './headset';
import { taught } from './input/lessons';
import type { Panel } from './panels/panel';
import type { People } from './bodies/people';
import type { Side } from '../store/xr-settings';
import { CAPITAL } from './drawing/sizes';

type PanelName = 'palette' | 'timeline' | 'question' | 'added';
type Triple = [number, number, number];

export function installHeadsetHook(
  engine: Engine,
  headset: Headset,
  overlays: Overlays,
  people: People,
): void {
  const { viewer } = engine;
  const inRig = (place: Vector3): Triple =>
    headset.cockpit!.rig.group.worldToLocal(place.clone()).toArray();
  const panel = (name: PanelName): Panel => headset.cockpit!.panels[name]!;
  const onPanel = (name: PanelName, u: number, v: number, out: number): Vector3 => {
    const { mesh, size } = panel(name);
    mesh.updateWorldMatrix(true, false);
    const at = mesh.position.clone().set((u - 0.5) * size.width, (0.5 - v) * size.height, out);
    return mesh.localToWorld(at);
  };
  const hook = {
    /** Pictures since the session began. */
    frames: () => headset.cockpit?.frames ?? 0,
    headset,
    /** Move a point (source coordinates) to the headset's own space. */
    place: ([x, y, z]: Triple): Triple => {
      const [sx, sy, sz] = peek(state.sequence)?.shift ?? [0, 0, 0];
      viewer.world.updateMatrixWorld(true);
      const at = viewer.camera.position.clone().set(x - sx, y - sy, z - sz);
      return inRig(at.applyMatrix4(viewer.room.matrixWorld));
    },
    /** Metres from the pointing ray's origin to the sphere's middle. */
    tipAhead: () => {
      const { painter, brush } = headset.cockpit!;
      return brush ? painter.tip.distanceTo(brush.origin) : 0;
    },
    /** Return a place on a panel (0..1 from the upper left) in space, and the panel's normal. */
    onPanel: (name: PanelName, u: number, v: number): { at: Triple; out: Triple } => ({
      at: inRig(onPanel(name, u, v, 0)),
      out: inRig(onPanel(name, u, v, 0.2)),
    }),
    /** The sphere of points highlighted by the shader, local coordinates. */
    lit: () => viewer.uniforms.lit,
    /** Height of a capital letter at a place of a panel, seen from the head, degrees. */
    capital: (name: PanelName, u: number, v: number): number => {
      const { size } = panel(name);
      const share = (CAPITAL * size.em) / size.height / 2;
      const { head } = headset.cockpit!.rig;
      const [upper, lower] = [v - share, v + share].map((at) =>
        onPanel(name, u, at, 0).sub(head),
      ) as [Vector3, Vector3];
      return (upper.angleTo(lower) * 180) / Math.PI;
    },
    /** Overlays of the recording: boxes, dots of trails, points of the ghost. */
    overlays: () => ({
      boxes: overlays.boxes.count,
      trails: overlays.trails.count,
      ghost: overlays.ghost.count,
    }),
    /** Doubtful labels here, and the run that stopped for them. */
    doubt: () => ({
      unsure: peek(unsure),
      halted: peek(halted),
      pulse: viewer.uniforms.pulse,
    }),
    /** The pointers: kind, side, buttons, and role. */
    pointers: () => {
      const { bodies, brush, other, palette } = headset.cockpit!.pointers;
      return bodies.map(({ pointer }) => ({
        kind: pointer.kind.name,
        side: pointer.side,
        device: pointer.device.id,
        tracked: pointer.tracked,
        roles: Object.entries({ brush, other, palette }).flatMap(([role, one]) =>
          one === pointer ? role : [],
        ),
      }));
    },
    /** The step of the first minute: the lesson that is taught. */
    taught: () => peek(taught),
    /** Hints beside the controllers. */
    tips: (side: Side) => {
      const { pointers } = headset.cockpit!;
      const pointer = pointers.of(side);
      return pointer ? pointers.bodyOf(pointer).tips.shown : [];
    },
    /** Other people in the room with a visible head, hands and brush. */
    people: () => people.seen(),
    /** Whether a panel is unfolded, so that its buttons can be pressed. */
    open: (name: PanelName) => panel(name).open,
    /** Name of the control of a panel under a ray. */
    pointedAt: (name: PanelName) => panel(name).pointedAt,
    /** Places on a panel that answer, 0..1. */
    areas: (name: PanelName) => panel(name).places(),
  };
  Object.defineProperty(window, '__pointbrushHeadset', { value: Object.freeze(hook) });
}
