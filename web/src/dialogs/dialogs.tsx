/** The dialog that is open, if any. */
import { dialog } from "../store";
import { CommandDialog, OpenDialog, PictureDialog, SaveDialog } from "./files";
import { HelpDialog } from "./help";
import { OperationDialog } from "./operation";
import { SearchDialog } from "./search";
import { SessionsDialog } from "./sessions";

export function Dialogs() {
  const open = dialog.value;
  switch (open?.name) {
    case "search": return <SearchDialog />;
    case "help": return <HelpDialog />;
    case "open": return <OpenDialog add={open.add} />;
    case "save": return <SaveDialog />;
    case "picture": return <PictureDialog plain={open.plain ?? false} />;
    case "sessions": return <SessionsDialog />;
    case "command": return <CommandDialog text={open.text} />;
    case "operation": return <OperationDialog key={open.operation} name={open.operation} />;
    default: return null;
  }
}
