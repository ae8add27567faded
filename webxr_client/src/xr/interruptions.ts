/** External events that interrupt work in the headset. */
import { actions } from '../store/actions';
import { state } from '../store/state';
import { follow, peek } from '../store/watch';

export interface Interrupted {
  /** The headset's space, or the recording, lies elsewhere from now on. */
  readonly moved: () => void;
  /** The system came in between: its menu is open, or nothing is seen. */
  readonly covered: () => void;
}

/** Follow the events of a session and its reference space; the result ends that. */
export function followInterruptions(
  session: XRSession,
  space: XRReferenceSpace | null,
  { moved, covered }: Interrupted,
): () => void {
  const seen = (): void => {
    if (session.visibilityState === 'visible') return;
    covered();
    // Playback stops while the recording is hidden.
    if (session.visibilityState === 'hidden' && peek(state.playing)) actions.time.togglePlay();
  };
  session.addEventListener('visibilitychange', seen);
  // The headset's own way to recentre moved its space: the next picture has the new poses.
  space?.addEventListener('reset', moved);
  // Another recording lies elsewhere: one stands before it once its first frame is there.
  let open = peek(state.sequence)?.id;
  const unsubscribe = follow(() => {
    const { value } = state.sequence;
    if (value && value.id !== open) moved();
    open = value?.id ?? open;
  });
  return () => {
    session.removeEventListener('visibilitychange', seen);
    space?.removeEventListener('reset', moved);
    unsubscribe();
  };
}
