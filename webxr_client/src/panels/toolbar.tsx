/** Above the canvas: recording, tools, history, tracking, export, people. */
import { signal } from '@preact/signals';
import type { ComponentChild } from 'preact';
import { actions } from '../store/actions';
import { limits, offers } from '../store/limits';
import { canEdit, canManage, notify, state, trackingJob, type Tool } from '../store/state';
import { chooseTheme, theme } from '../store/theme';
import { Button } from './parts/controls';
import { ExportButton } from './export-menu';
import { HistoryButton } from './history-menu';
import { helpOpen, MenuItem, PopoverButton } from './parts/popover';
import { ConnectionStatus, People } from './people';
import { RadioGroup, type RadioOption } from './parts/radio-group';
import { SequenceMenu } from './importing/sequence-menu';
import { OthersJobs } from './stage/jobs';
import { ToolOptions } from './tool-options';
import { TrackForm, trackOpen } from './timeline/track-form';

const TOOLS: readonly RadioOption<Tool>[] = [
  { value: 'navigate', icon: 'navigate', label: 'Look', tip: 'Look around: drag to turn', keys: 'V' },
  { value: 'paint', icon: 'brush', label: 'Paint', tip: 'Paint the active label', keys: 'B' },
  { value: 'erase', icon: 'eraser', label: 'Erase', tip: 'Erase labels', keys: 'C' },
  { value: 'boxes', icon: 'box', label: 'Boxes', tip: 'Boxes of objects: choose, fit, draw', keys: 'Shift B' },
]; // prettier-ignore
const RARE_TOOLS: readonly RadioOption<Tool>[] = [
  { value: 'pick', icon: 'picker', label: 'Pick', tip: 'Choose the label under the pointer', keys: 'I' },
  { value: 'delete', icon: 'noise', label: 'Delete', tip: 'Delete noise points', keys: 'X' },
  { value: 'restore', icon: 'restore', label: 'Restore', tip: 'Restore deleted points', keys: 'Shift X' },
]; // prettier-ignore

/** Whether there is room for the names of all tools. */
const room = matchMedia('(width >= 1440px)');
const roomy = signal(room.matches);
room.addEventListener('change', () => (roomy.value = room.matches));

export function Toolbar({ buttons }: { buttons: readonly (() => ComponentChild)[] }) {
  const study = limits.value;
  if (!state.sequence.value) return <WelcomeBar />;
  return (
    <>
      <div class="toolbar-row line">
        {study ? <study.Bar /> : <SequenceMenu />}
        <span class="divider" />
        <Tools />
        <span class="divider" />
        <History />
        <span class="spacer" />
        {offers('track') && <TrackButton />}
        {!study && buttons.map((More) => <More />)}
        {!study && <ExportButton />}
        <People />
        <ConnectionStatus />
        <OthersJobs />
        {!study && <VrButton />}
        <ThemeButton />
        <HelpButton />
      </div>
      <ToolOptions />
    </>
  );
}

function WelcomeBar() {
  return (
    <div class="toolbar-row line">
      <span class="title">pointbrush</span>
      <span class="spacer" />
      {canManage.value && (
        <Button
          label="Studies"
          tip="Compare ways of labelling with participants"
          onClick={() => void actions.page.openStudies()}
        />
      )}
      <ConnectionStatus />
      <OthersJobs />
      <ThemeButton />
      <HelpButton />
    </div>
  );
}

function Tools() {
  const tool = state.tool.value;
  const shown = roomy.value || limits.value !== null;
  const rare = RARE_TOOLS.filter(({ value }) => shown || value === tool);
  const offered = [...TOOLS, ...rare].filter(({ value }) => offers(value));
  const options = offered.map((entry) => ({
    ...entry,
    disabled: entry.value !== 'navigate' && entry.value !== 'boxes' && !canEdit.value,
  }));
  return (
    <>
      <RadioGroup
        label="Tool"
        class="group tools"
        options={options}
        value={tool}
        onChoose={(chosen) => actions.tools.setTool(chosen)}
      />
      {!roomy.value && !limits.value && <MoreTools />}
    </>
  );
}

const moreOpen = signal(false);

/** Tools for which there is no room, by name. */
function MoreTools() {
  return (
    <PopoverButton open={moreOpen} icon="more" tip="More tools" button={{ label: 'More' }} label="More tools">
      {RARE_TOOLS.map(({ value, icon, tip, keys }) => (
        <MenuItem key={value} icon={icon!} label={tip!} disabled={!canEdit.value} onClick={() => actions.tools.setTool(value)}>
          <span class="end">{keys}</span>
        </MenuItem>
      ))}
    </PopoverButton>
  ); // prettier-ignore
}

function History() {
  const undo = state.undo.value;
  const redo = state.redo.value;
  return (
    <div class="group">
      <Button
        icon="undo"
        tip={undo === null ? 'Nothing to undo' : `Undo: ${undo}`}
        keys="Ctrl Z"
        disabled={undo === null}
        onClick={() => actions.history.undo()}
      />
      <Button
        icon="redo"
        tip={redo === null ? 'Nothing to redo' : `Redo: ${redo}`}
        keys="Ctrl Shift Z"
        disabled={redo === null}
        onClick={() => actions.history.redo()}
      />
      <HistoryButton />
    </div>
  );
}

function TrackButton() {
  return (
    <PopoverButton
      open={trackOpen}
      icon="track"
      button={{ label: 'Track…', class: 'track-button' }}
      tip="Track labels through the following or preceding frames"
      disabled={!canEdit.value || trackingJob.value !== null}
      label="Track labels"
      class="form"
    >
      <TrackForm />
    </PopoverButton>
  );
}

function VrButton() {
  const { supported, session, passthrough, enters, detail } = state.xr.value;
  if (!supported) {
    const looking = supported === null; // its place is reserved
    const tip = looking ? 'Looking for a headset…' : `No headset. ${detail}`;
    const why = (): void => void notify('info', 'No headset', detail);
    return <Button icon="headset" tip={tip} disabled={looking} onClick={why} />;
  }
  if (session === 'running') {
    return (
      <Button
        icon="exit"
        label={`Leave ${enters}`}
        kind="outlined"
        onClick={() => void actions.page.exitVR()}
      />
    );
  }
  const starting = session === 'starting';
  return (
    <div class="group">
      <Button
        icon="headset"
        label={`Enter ${enters}`}
        kind="primary"
        tip="Show the recording in the headset"
        disabled={starting}
        onClick={() => void actions.page.enterVR()}
      />
      {passthrough && (
        <Button
          icon="eye"
          kind="outlined"
          tip="Enter with passthrough: the real room stays visible"
          disabled={starting}
          onClick={() => void actions.page.enterVR(true)}
        />
      )}
    </div>
  );
}

function ThemeButton() {
  const other = theme.value === 'light' ? 'dark' : 'light';
  return (
    <Button
      icon={other === 'light' ? 'sun' : 'moon'}
      tip={other === 'light' ? 'Light theme' : 'Dark theme'}
      onClick={() => chooseTheme(other)}
    />
  );
}

function HelpButton() {
  return (
    <Button icon="help" tip="Keyboard and mouse" keys="?" onClick={() => (helpOpen.value = true)} />
  );
}
