from .contact_sheet import contact_sheet
from .description import describe
from .for_torch import torch_dataset, torch_render_stream, torch_renders, torch_stream
from .job_file import Job, load_job
from .reading import Views, batches, open_views
from .running import RunReport, VerifyReport, run, verify
from .webdataset import to_webdataset

__all__ = [
    "Job",
    "RunReport",
    "VerifyReport",
    "Views",
    "batches",
    "contact_sheet",
    "describe",
    "load_job",
    "open_views",
    "run",
    "to_webdataset",
    "torch_dataset",
    "torch_render_stream",
    "torch_renders",
    "torch_stream",
    "verify",
]
