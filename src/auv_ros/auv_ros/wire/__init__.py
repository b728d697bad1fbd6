"""Bytes on the wire: conversion between the data of components and serialised ROS messages."""
