/** For tests: input sources as the WebXR input profiles registry describes them. */
import { TestSource } from './sources';

interface Component {
  readonly type: 'trigger' | 'squeeze' | 'touchpad' | 'thumbstick' | 'button';
}

export interface Layout {
  readonly selectComponentId: string;
  readonly components: Readonly<Record<string, Component>>;
  readonly gamepad?: {
    readonly buttons: readonly (string | null)[];
    readonly axes: readonly ({ readonly componentId: string; readonly axis: string } | null)[];
  };
}

export interface Profile {
  readonly profileId: string;
  readonly fallbackProfileIds?: readonly string[];
  /** By sides, joined with hyphens: `left`, `left-right-none`. */
  readonly layouts: Readonly<Record<string, Layout>>;
}

const FILES = import.meta.glob<Profile>(
  '/node_modules/@webxr-input-profiles/registry/dist/profiles/**/*.json',
  { eager: true, import: 'default' },
);

export const PROFILES: readonly Profile[] = Object.values(FILES);

export function profileOf(id: string): Profile {
  const found = PROFILES.find(({ profileId }) => profileId === id);
  if (!found) throw new Error(`The registry has no profile ${id}.`);
  return found;
}

/** The layout of a side, or of a profile that has none for it the first one. */
export function layoutOf({ layouts }: Profile, side: XRHandedness): Layout {
  const found = Object.entries(layouts).find(([sides]) => sides.split('-').includes(side));
  return (found ?? Object.entries(layouts)[0]!)[1];
}

/** A tracked source of a profile; `joints`: its runtime gives joints beside the gamepad. */
export function registered(id: string, side: XRHandedness, joints = false): TestSource {
  const profile = profileOf(id);
  const { gamepad } = layoutOf(profile, side);
  return new TestSource({
    side,
    profiles: [id, ...(profile.fallbackProfileIds ?? [])],
    hand: joints,
    buttons: gamepad?.buttons ?? [],
    axes: (gamepad?.axes ?? []).map(() => 0),
  });
}
