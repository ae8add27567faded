/** The place of a note: the next click in the cloud gives it. */
import { Button } from '../panels/parts/controls';
import type { Place } from './model';
import { pointing } from './store';

interface PinProps {
  place: Place | null;
  onPin: (place: Place | null) => void;
}

export function Pin({ place, onPin }: PinProps) {
  const waits = pointing.value !== null;
  const point = (): void => {
    pointing.value = waits ? null : onPin;
  };
  return (
    <div class="review-pin">
      <Button
        icon="target"
        label={waits ? 'Click the place…' : place ? 'Pinned: change the place' : 'Pin to a place'}
        kind="outlined"
        small
        pressed={waits}
        onClick={point}
      />
      {place && <Button icon="close" tip="Remove the pin" small onClick={() => onPin(null)} />}
    </div>
  );
}
