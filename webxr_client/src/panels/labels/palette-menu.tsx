/** The whole palette: labels of a template or a file, and the palette as a file. */
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { actions } from '../../store/actions';
import { canEdit, state } from '../../store/state';
import { templates } from '../../engine/palette-files';
import { plural } from '../../common/format';
import { Icon } from '../../common/icons';
import { chooseSafeColours, safeColours } from '../../store/safe-colours';
import { Check } from '../parts/controls';
import { PopoverButton } from '../parts/popover';

const open = signal(false);
const close = (): void => {
  open.value = false;
};

export function PaletteMenuButton() {
  return (
    <PopoverButton open={open} icon="more" tip="Templates and palette files" small label="Palette">
      <Menu />
    </PopoverButton>
  );
}

const NAMES: Readonly<Record<string, string>> = {
  semantickitti: 'SemanticKITTI',
  nuscenes: 'nuScenes',
  las: 'LAS',
  scannet: 'ScanNet',
};

function Menu() {
  useEffect(() => void actions.loadTemplates(), []);
  const cannot = !canEdit.value;
  return (
    <>
      <h2>Add the labels of</h2>
      {templates.value.map(({ name, labels }) => (
        <button
          key={name}
          type="button"
          class="menu-item"
          disabled={cannot}
          onClick={() => {
            close();
            void actions.addTemplate(name);
          }}
        >
          <Icon name="layers" /> {NAMES[name] ?? name}
          <span class="end number">{plural(labels, 'label')}</span>
        </button>
      ))}
      <button
        type="button"
        class="menu-item"
        disabled={cannot}
        onClick={() => {
          close();
          actions.pickPalette();
        }}
      >
        <Icon name="import" /> A palette file…
      </button>
      <hr />
      <Check
        label="Colours for colour-blind users"
        tip="New labels and the colour picker use colours that are distinct with every kind of colour blindness"
        checked={safeColours.value}
        onChange={chooseSafeColours}
      />
      <button
        type="button"
        class="menu-item"
        disabled={cannot || state.palette.value.length === 0}
        onClick={() => {
          close();
          void actions.recolorAll();
        }}
      >
        <Icon name="swap" /> Apply these colours to all labels
      </button>
      <hr />
      <button
        type="button"
        class="menu-item"
        disabled={state.palette.value.length === 0}
        onClick={() => {
          close();
          void actions.savePalette();
        }}
      >
        <Icon name="export" /> Save the palette as a file
      </button>
    </>
  );
}
