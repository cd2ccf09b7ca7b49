"""A tf2_msgs/msg/TFMessage class where tf2_msgs is not installed (the wheels on PyPI have none).

A TFMessage is ``geometry_msgs/TransformStamped[] transforms`` and nothing else, and rmw_fastrtps
describes a message by two C tables (callbacks, members). This module fills both tables for the one
field from the tables that geometry_msgs ships, with ctypes. Type name and type hash are those of
tf2_msgs, so other ROS nodes see no difference.

Not modelled: a Python message object. The class only carries the type support: publish the bytes
of :func:`mecanum_base.ros.transforms.encode`, subscribe with ``raw=True``. The node service
``~/get_type_description`` would describe TransformStamped under this hash.
"""

from __future__ import annotations

import ctypes
import functools
from typing import Any

from mecanum_base.core.errors import MecanumBaseError

# rosidl's hash of "geometry_msgs/TransformStamped[] transforms" in tf2_msgs/msg/TFMessage
TYPE_HASH = 'e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087'
_FAST, _INTROSPECTION = b'rosidl_typesupport_fastrtps_c', b'rosidl_typesupport_introspection_c'
_TYPE_MESSAGE = 18  # rosidl_typesupport_introspection_c__ROS_TYPE_MESSAGE
_SEQUENCE_SIZE = 24  # data pointer, size, capacity
_Pointer = ctypes.c_void_p
_Lookup = ctypes.CFUNCTYPE(_Pointer, _Pointer, ctypes.c_char_p)
_HashOf = ctypes.CFUNCTYPE(_Pointer, _Pointer)


class TransformsUnavailable(MecanumBaseError):
    """The message class cannot be derived; the text says why."""


class _Hash(ctypes.Structure):  # rosidl_type_hash_t
    _fields_ = [('version', ctypes.c_uint8), ('value', ctypes.c_uint8 * 32)]


class _Handle(ctypes.Structure):  # rosidl_message_type_support_t
    _fields_ = [('identifier', ctypes.c_char_p), ('data', _Pointer), ('lookup', _Pointer),
                ('hash', _Pointer), ('description', _Pointer), ('sources', _Pointer)]


class _Callbacks(ctypes.Structure):  # message_type_support_callbacks_t of rmw_fastrtps
    _fields_ = [('namespace', ctypes.c_char_p), ('name', ctypes.c_char_p),
                ('serialize', _Pointer), ('deserialize', _Pointer), ('size', _Pointer),
                ('max_size', _Pointer), ('key', _Pointer)]


class _Member(ctypes.Structure):  # rosidl_typesupport_introspection_c__MessageMember
    _fields_ = [('name', ctypes.c_char_p), ('type_id', ctypes.c_uint8),
                ('string_bound', ctypes.c_size_t), ('members', _Pointer),
                ('is_key', ctypes.c_bool), ('is_array', ctypes.c_bool),
                ('array_size', ctypes.c_size_t), ('is_bounded', ctypes.c_bool),
                ('offset', ctypes.c_uint32), ('default', _Pointer),
                *((f'function_{i}', _Pointer) for i in range(6))]


class _Members(ctypes.Structure):  # rosidl_typesupport_introspection_c__MessageMembers
    _fields_ = [('namespace', ctypes.c_char_p), ('name', ctypes.c_char_p),
                ('count', ctypes.c_uint32), ('size_of', ctypes.c_size_t),
                ('has_key', ctypes.c_bool), ('members', _Pointer), ('init', _Pointer),
                ('fini', _Pointer)]


_alive: list[Any] = []  # the C side keeps pointers into these for the life of the process


@functools.lru_cache(maxsize=1)
def derived_tf_message() -> Any:
    """The class to give to create_publisher and create_subscription (raw=True).

    Raises TransformsUnavailable with another RMW than rmw_fastrtps_cpp, or if rosidl's tables are
    not laid out as expected.
    """
    from geometry_msgs.msg import TransformStamped
    from rclpy.type_support import check_for_type_support
    from rclpy.utilities import get_rmw_implementation_identifier
    rmw = get_rmw_implementation_identifier()
    if rmw != 'rmw_fastrtps_cpp':
        raise TransformsUnavailable(f'tf2_msgs is not installed, and {rmw} cannot do without it')
    check_for_type_support(TransformStamped)
    meta: Any = TransformStamped.__class__
    name, base = _handle_of_capsule(meta._TYPE_SUPPORT)
    lookup = _Lookup(base.lookup)
    addresses = [lookup(ctypes.addressof(base), kind) for kind in (_FAST, _INTROSPECTION)]
    if not all(addresses):
        raise TransformsUnavailable('tf2_msgs is not installed, and geometry_msgs has no type '
                                    'support for fastrtps')
    fast, introspection = (_Handle.from_address(address) for address in addresses)
    element = _Callbacks.from_address(fast.data)
    if (element.namespace, element.name) != (b'geometry_msgs::msg', b'TransformStamped'):
        raise TransformsUnavailable('tf2_msgs is not installed, and the type support of '
                                    'geometry_msgs is laid out in an unknown way')
    support = _type_support(fast, introspection, addresses[1], element)

    class TFMessageMeta(type):
        _TYPE_SUPPORT = _new_capsule(support, name)
        _CREATE_ROS_MESSAGE, _CONVERT_FROM_PY = meta._CREATE_ROS_MESSAGE, meta._CONVERT_FROM_PY
        _CONVERT_TO_PY, _DESTROY_ROS_MESSAGE = meta._CONVERT_TO_PY, meta._DESTROY_ROS_MESSAGE

    derived = TFMessageMeta('TFMessage', (), {'__slots__': ()})
    derived.__module__ = 'tf2_msgs.msg'
    return derived


def _type_support(fast: _Handle, introspection: _Handle, element_address: int,
                  element: _Callbacks) -> int:
    """Address of the type support of a message with one field: a sequence of the element."""
    members_of_element = _Members.from_address(introspection.data)
    callbacks = _Callbacks(b'tf2_msgs::msg', b'TFMessage', element.serialize, element.deserialize,
                           element.size, element.max_size, None)
    member = _Member(b'transforms', _TYPE_MESSAGE, 0, element_address, False, True, 0, False, 0,
                     None)
    members = _Members(b'tf2_msgs__msg', b'TFMessage', 1, _SEQUENCE_SIZE, False,
                       ctypes.addressof(member), members_of_element.init, members_of_element.fini)
    type_hash = _Hash(1, (ctypes.c_uint8 * 32)(*bytes.fromhex(TYPE_HASH)))
    handles: dict[bytes, _Handle] = {}
    select = _Lookup(lambda _, kind: (ctypes.addressof(handles[kind]) if kind in handles
                                      else None))
    hash_of = _HashOf(lambda _: ctypes.addressof(type_hash))
    for kind, table, source in ((_FAST, callbacks, fast), (_INTROSPECTION, members,
                                                           introspection)):
        handles[kind] = _Handle(source.identifier, ctypes.addressof(table),
                                ctypes.cast(select, _Pointer), ctypes.cast(hash_of, _Pointer),
                                source.description, source.sources)
    _alive.extend((callbacks, member, members, type_hash, handles, select, hash_of))
    return ctypes.addressof(handles[_FAST])


def _handle_of_capsule(capsule: Any) -> tuple[bytes, _Handle]:
    """(name, handle) of a PyCapsule that wraps a rosidl_message_type_support_t."""
    api = ctypes.pythonapi
    api.PyCapsule_GetName.restype = ctypes.c_char_p
    api.PyCapsule_GetName.argtypes = [ctypes.py_object]
    api.PyCapsule_GetPointer.restype = _Pointer
    api.PyCapsule_GetPointer.argtypes = [ctypes.py_object, ctypes.c_char_p]
    name = api.PyCapsule_GetName(capsule)
    return name, _Handle.from_address(api.PyCapsule_GetPointer(capsule, name))


def _new_capsule(address: int, name: bytes) -> Any:
    api = ctypes.pythonapi
    api.PyCapsule_New.restype = ctypes.py_object
    api.PyCapsule_New.argtypes = [_Pointer, ctypes.c_char_p, _Pointer]
    _alive.append(name)
    return api.PyCapsule_New(address, name, None)
