"""The parametric study of fault propagation: its runs, their measures, its report (tools/fault_study)."""
