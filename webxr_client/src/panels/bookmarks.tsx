/** Views that were kept: go to one, rename it, drop it. */
import type { RefObject } from 'preact';
import { actions } from '../actions';
import { bookmarks, removeBookmark, renameBookmark, type Bookmark } from '../engine/bookmarks';
import { Button } from './controls';
import { Popover } from './popover';

interface BookmarksProps {
  anchor: RefObject<HTMLElement | null>;
  onClose: () => void;
}

export function Bookmarks({ anchor, onClose }: BookmarksProps) {
  return (
    <Popover anchor={anchor} label="Views to come back to" onClose={onClose} class="bookmarks">
      {bookmarks.value.map((one, index) => (
        <Row key={`${index} ${one.name}`} one={one} index={index} />
      ))}
      {bookmarks.value.length === 0 && (
        <p class="soft">A kept view brings back place, direction and frame.</p>
      )}
      <Button
        icon="plus"
        label="Keep this view"
        kind="outlined"
        onClick={() => actions.keepView()}
      />
    </Popover>
  );
}

function Row({ one, index }: { one: Bookmark; index: number }) {
  return (
    <div class="row">
      <Button icon="target" tip={`Go to ${one.name}`} onClick={() => actions.goToView(one)} />
      <input
        class="field"
        aria-label="Name of the view"
        defaultValue={one.name}
        maxLength={80}
        onKeyDown={(event) => event.key !== 'Escape' && event.stopPropagation()}
        onChange={(event) => renameBookmark(index, event.currentTarget.value)}
      />
      <span class="soft number">frame {one.frame}</span>
      <Button icon="trash" tip={`Drop ${one.name}`} onClick={() => removeBookmark(index)} />
    </div>
  );
}
