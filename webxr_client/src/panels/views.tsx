/** Over the canvas, top right: where to look from, and what the camera goes along with. */
import { signal } from '@preact/signals';
import { useRef } from 'preact/hooks';
import { actions, type ViewPreset } from '../actions';
import { orthographic } from '../desktop/views';
import { followsObject } from '../engine/going';
import { Bookmarks } from './bookmarks';
import { Button } from './controls';

const VIEWS: readonly (readonly [ViewPreset, string, string, string])[] = [
  ['sensor', 'Sensor', 'Look from where the sensor stood', 'R'],
  ['top', 'Top', 'Plan from above, to scale', 'T'],
  ['front', 'Front', 'Elevation from the front, to scale', ''],
  ['left', 'Side', 'Elevation from the side, to scale', ''],
  ['fit', 'Fit', 'Show everything', ''],
];

const bookmarksOpen = signal(false);

export function Views() {
  const anchor = useRef<HTMLButtonElement>(null);
  return (
    <div class="views" role="group" aria-label="View">
      {VIEWS.map(([preset, name, tip, keys]) => (
        <Button
          key={preset}
          label={name}
          tip={tip}
          keys={keys || undefined}
          onClick={() => actions.viewFrom(preset)}
        />
      ))}
      <span class="divider" />
      <Button
        icon="view"
        tip="Orthographic: parallel lines stay parallel"
        keys="P"
        pressed={orthographic.value}
        onClick={() => actions.toggleOrthographic()}
      />
      <Button
        icon="target"
        tip="Go to the active label’s object"
        keys="F"
        onClick={() => actions.goToObject()}
      />
      <Button
        icon="track"
        tip="Go along with the active label’s object from frame to frame"
        pressed={followsObject.value}
        onClick={() => (followsObject.value = !followsObject.value)}
      />
      <Button
        buttonRef={anchor}
        icon="bookmark"
        tip="Views to come back to"
        expanded={bookmarksOpen.value}
        onClick={() => (bookmarksOpen.value = !bookmarksOpen.value)}
      />
      {bookmarksOpen.value && (
        <Bookmarks anchor={anchor} onClose={() => (bookmarksOpen.value = false)} />
      )}
    </div>
  );
}
