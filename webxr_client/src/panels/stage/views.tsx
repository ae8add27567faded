/** Over the canvas, top right: where to look from, and what the camera goes along with. */
import { signal } from '@preact/signals';
import type { RefObject } from 'preact';
import { useRef } from 'preact/hooks';
import { actions, type ViewPreset } from '../../store/actions';
import { orthographic } from '../../view/framing';
import type { Bookmark } from '../../store/types';
import { bookmarks, removeBookmark, renameBookmark } from '../../view/bookmarks';
import { followsObject } from '../../view/going';
import { Button } from '../parts/controls';
import { Popover } from '../parts/popover';

const VIEWS: readonly (readonly [ViewPreset, string, string, string])[] = [
  ['sensor', 'Sensor', 'Look from the position of the sensor', 'R'],
  ['top', 'Top', 'Plan from above, to scale', 'T'],
  ['front', 'Front', 'Elevation from the front, to scale', ''],
  ['left', 'Side', 'Elevation from the side, to scale', ''],
  ['fit', 'Fit', 'Show everything', ''],
];

const bookmarksOpen = signal(false);

export function Views() {
  const anchor = useRef<HTMLButtonElement>(null);
  return (
    <div class="views small" role="group" aria-label="View">
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
        tip="Follow the active label’s object from frame to frame"
        pressed={followsObject.value}
        onClick={() => (followsObject.value = !followsObject.value)}
      />
      <Button
        buttonRef={anchor}
        icon="bookmark"
        tip="Saved views"
        expanded={bookmarksOpen.value}
        onClick={() => (bookmarksOpen.value = !bookmarksOpen.value)}
      />
      {bookmarksOpen.value && (
        <Bookmarks anchor={anchor} onClose={() => (bookmarksOpen.value = false)} />
      )}
    </div>
  );
}

interface BookmarksProps {
  anchor: RefObject<HTMLElement | null>;
  onClose: () => void;
}

/** Views that were kept: go to one, rename it, drop it. */
function Bookmarks({ anchor, onClose }: BookmarksProps) {
  return (
    <Popover anchor={anchor} label="Saved views" onClose={onClose} class="form">
      {bookmarks.value.map((one, index) => (
        <Row key={`${index} ${one.name}`} one={one} index={index} />
      ))}
      {bookmarks.value.length === 0 && (
        <p class="soft">A saved view restores camera position, direction and frame.</p>
      )}
      <Button
        icon="plus"
        label="Save this view"
        kind="outlined"
        onClick={() => actions.keepView()}
      />
    </Popover>
  );
}

function Row({ one, index }: { one: Bookmark; index: number }) {
  return (
    <div class="line">
      <Button icon="target" tip={`Go to ${one.name}`} onClick={() => actions.goToView(one)} />
      <input
        class="field grow"
        aria-label="Name of the view"
        defaultValue={one.name}
        maxLength={80}
        onKeyDown={(event) => event.key !== 'Escape' && event.stopPropagation()}
        onChange={(event) => renameBookmark(index, event.currentTarget.value)}
      />
      <span class="soft number">frame {one.frame}</span>
      <Button icon="trash" tip={`Delete ${one.name}`} onClick={() => removeBookmark(index)} />
    </div>
  );
}
