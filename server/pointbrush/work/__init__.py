"""What the workspace does with sequences and labels together, one module per job or action."""
